# The processor that the solver's inner loops are compiled for, decided in one place.
#
# ANGIO_CPU  AUTO: x86-64-v3 (AVX2 and fused multiply-add) where the machine that builds has it, else
#            what the compiler takes by itself. Or a name for the compiler's -march, as native, or
#            x86-64 for programs that are to run anywhere.
set(ANGIO_CPU "AUTO" CACHE STRING "Processor of the solver's inner loops: AUTO, or a name for -march")

set(ANGIO_CPU_OPTIONS)
if(NOT ANGIO_CPU STREQUAL "AUTO")
  set(ANGIO_CPU_OPTIONS -march=${ANGIO_CPU})
elseif(NOT CMAKE_CROSSCOMPILING)
  include(CheckCXXSourceRuns)
  check_cxx_source_runs("
    #if !defined(__x86_64__)
    #error another family of processors
    #endif
    int main() { return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") ? 0 : 1; }"
    ANGIO_CPU_HAS_AVX2)
  if(ANGIO_CPU_HAS_AVX2)
    set(ANGIO_CPU_OPTIONS -march=x86-64-v3)
  endif()
endif()
