#!/usr/bin/env bash
# As OSS-Fuzz calls it: $CXX and $CXXFLAGS compile, $LIB_FUZZING_ENGINE is linked, $OUT gets the programs with
# their corpora. Alone, on Debian 12 with clang-14, it sets these itself: fuzz/build.sh FOLDER
set -euo pipefail
source=$(realpath "$(dirname "${BASH_SOURCE[0]}")/..")
OUT=${OUT:-$(realpath -m "${1:?fuzz/build.sh FOLDER}")}
CXX=${CXX:-clang++-14} CC=${CC:-clang-14}
CXXFLAGS=${CXXFLAGS:--O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize=vptr -fno-sanitize-recover=undefined}
CXXFLAGS="$CXXFLAGS -include $source/fuzz/itk_with_clang.hpp"
LIB_FUZZING_ENGINE=${LIB_FUZZING_ENGINE:--fsanitize=fuzzer}
stages=${ANGIO_STAGES:-all}
mkdir -p "$OUT"
cmake -S "$source" -B "$OUT/build" -G Ninja -DCMAKE_BUILD_TYPE=None -DANGIO_FUZZ=ON -DANGIO_CUDA=OFF -DANGIO_TESTS=OFF \
  -DANGIO_BENCHMARKS=OFF -DANGIO_CHECKS=ON "-DANGIO_STAGES=$stages" "-DANGIO_FUZZ_ENGINE=$LIB_FUZZING_ENGINE" \
  -DCMAKE_C_COMPILER="$CC" -DCMAKE_CXX_COMPILER="$CXX" "-DCMAKE_CXX_FLAGS=$CXXFLAGS" \
  "-DCMAKE_C_FLAGS=$CXXFLAGS" "-DCMAKE_EXE_LINKER_FLAGS=-fsanitize=address,undefined"
cmake --build "$OUT/build" --target ${TARGETS:-fuzz/all}
for program in "$OUT"/build/fuzz/*_fuzzer; do
  name=$(basename "$program" _fuzzer)
  cp "$program" "$OUT/"
  (cd "$source/fuzz/corpus/$name" && python3 -m zipfile -c "$OUT/${name}_fuzzer_seed_corpus.zip" ./*)
done
