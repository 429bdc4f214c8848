# The processor that the solver's inner loops are compiled for, decided in one place.
#
# ANGIO_CPU  AUTO: x86-64-v3 (AVX2 and fused multiply-add) where the machine that builds has it, else
#            what the compiler takes by itself. Or a name for the compiler's -march, as native, or
#            x86-64 for programs that are to run anywhere. ANY: compiled for both, and chosen when the
#            program runs.
set(ANGIO_CPU "AUTO" CACHE STRING "Processor of the solver's inner loops: AUTO, ANY, or a name for -march")

set(ANGIO_CPU_OPTIONS)
if(ANGIO_CPU STREQUAL "ANY")
  set(ANGIO_CPU_OPTIONS -march=x86-64)
elseif(NOT ANGIO_CPU STREQUAL "AUTO")
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

# angio_add_v3_copy(TARGET SOURCES ... FUNCTIONS ... LINK ...)
# Adds SOURCES to TARGET once more, compiled for x86-64-v3 into one object that shows nothing to the linker
# but FUNCTIONS, named with _v3 at their end. Were its inline functions and templates not hidden, the linker
# could take them in place of the others', and the program would fail on processors without AVX2.
function(angio_add_v3_copy target)
  cmake_parse_arguments(ARG "" "" "SOURCES;FUNCTIONS;LINK" ${ARGN})
  set(copy ${target}_v3)
  add_library(${copy} OBJECT ${ARG_SOURCES})
  target_link_libraries(${copy} PRIVATE angio_warnings ${ARG_LINK})
  target_include_directories(${copy} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_features(${copy} PRIVATE cxx_std_20)
  target_compile_options(${copy} PRIVATE -march=x86-64-v3 -fno-gnu-unique)  # unique ones cannot be hidden
  set(shown)
  foreach(name IN LISTS ARG_FUNCTIONS)
    target_compile_definitions(${copy} PRIVATE ${name}=${name}_v3)
    list(APPEND shown "--keep-global-symbol=*${name}_v3*")
  endforeach()
  set(object ${CMAKE_CURRENT_BINARY_DIR}/${copy}.o)
  add_custom_command(OUTPUT ${object}
    COMMAND ${CMAKE_LINKER} -r --force-group-allocation -o ${object}.all $<TARGET_OBJECTS:${copy}>
    COMMAND ${CMAKE_OBJCOPY} --wildcard ${shown} ${object}.all ${object}
    DEPENDS ${copy} $<TARGET_OBJECTS:${copy}>
    COMMAND_EXPAND_LISTS VERBATIM)
  set_source_files_properties(${object} PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
  target_sources(${target} PRIVATE ${object})
endfunction()
