# CUDA, decided in one place. Everything builds and runs without it.
#
# ANGIO_CUDA                AUTO: used if nvcc is there, and an architecture to compile for. ON: an error
#                           if nvcc is not there. OFF: never.
# ANGIO_CUDA_ARCHITECTURES  native: the GPUs of this computer; none, if there are none (ON then compiles
#                           for all). all: Turing to Hopper, and what comes after. Or a list, as
#                           CMAKE_CUDA_ARCHITECTURES takes it.
#
# The language is enabled here, at file scope of the top directory, as CMake asks; only if there is
# something to compile with it, because finding a CUDA compiler takes seconds.
set(ANGIO_CUDA "AUTO" CACHE STRING "CUDA backend: AUTO, ON or OFF")
set_property(CACHE ANGIO_CUDA PROPERTY STRINGS AUTO ON OFF)
if(NOT ANGIO_CUDA MATCHES "^(AUTO|ON|OFF)$")
  message(FATAL_ERROR "ANGIO_CUDA is ${ANGIO_CUDA}, but must be AUTO, ON or OFF")
endif()

set(ANGIO_CUDA_ARCHITECTURES "native" CACHE STRING
  "GPU architectures: native, all, or a list (see CMAKE_CUDA_ARCHITECTURES)")

# Machine code from Turing to Hopper, and Hopper's PTX for what comes after.
set(angio_all_architectures 75-real 80-real 86-real 89-real 90)

# angio_find_native(RESULT): the architectures of this computer's GPUs; empty: there are none. A GPU that is
# newer than nvcc gets the newest PTX that nvcc makes, and one that is older than nvcc's oldest nothing.
function(angio_find_native result)
  set(architectures)
  set(capabilities)
  set(nvcc ${CMAKE_CUDA_COMPILER})
  if(NOT nvcc)
    set(nvcc $ENV{CUDACXX})
  endif()
  find_program(ANGIO_NVIDIA_SMI nvidia-smi PATHS /usr/lib/wsl/lib)
  if(ANGIO_NVIDIA_SMI AND nvcc)
    execute_process(COMMAND ${ANGIO_NVIDIA_SMI} --query-gpu=compute_cap --format=csv,noheader
      OUTPUT_VARIABLE capabilities ERROR_QUIET)
    execute_process(COMMAND ${nvcc} --list-gpu-arch OUTPUT_VARIABLE known ERROR_QUIET)
    string(REGEX MATCHALL "[0-9]+" known "${known}")
    list(SORT known COMPARE NATURAL ORDER DESCENDING)
    list(GET known 0 newest)
  endif()
  string(REGEX MATCHALL "[0-9]+\\.[0-9]" capabilities "${capabilities}")
  foreach(capability IN LISTS capabilities)
    string(REPLACE "." "" architecture ${capability})
    if(architecture IN_LIST known)
      list(APPEND architectures ${architecture}-real)
    elseif(architecture GREATER newest)
      list(APPEND architectures ${newest}-virtual)
    endif()
  endforeach()
  list(REMOVE_DUPLICATES architectures)
  set(${result} ${architectures} PARENT_SCOPE)
endfunction()

file(GLOB_RECURSE angio_cuda_sources ${PROJECT_SOURCE_DIR}/simulation/*.cu
  ${PROJECT_SOURCE_DIR}/reconstruction/*.cu)
set(ANGIO_CUDA_ENABLED OFF)
if(NOT ANGIO_CUDA STREQUAL "OFF")
  if(NOT CMAKE_CUDA_COMPILER AND NOT DEFINED ENV{CUDACXX})
    # NVIDIA's own packages do not put nvcc on the PATH.
    find_program(ANGIO_NVCC nvcc HINTS ENV CUDA_PATH ENV CUDA_HOME PATHS /usr/local/cuda
      PATH_SUFFIXES bin)
    if(ANGIO_NVCC)
      set(CMAKE_CUDA_COMPILER ${ANGIO_NVCC})
    endif()
  endif()
  set(angio_architectures ${ANGIO_CUDA_ARCHITECTURES})
  if(ANGIO_CUDA_ARCHITECTURES STREQUAL "native")
    angio_find_native(angio_architectures)
  endif()
  if(ANGIO_CUDA_ARCHITECTURES STREQUAL "all" OR (ANGIO_CUDA STREQUAL "ON" AND NOT angio_architectures))
    set(angio_architectures ${angio_all_architectures})
  endif()
  if(angio_architectures AND (angio_cuda_sources OR ANGIO_CUDA STREQUAL "ON"))
    include(CheckLanguage)
    check_language(CUDA)
    if(CMAKE_CUDA_COMPILER AND angio_cuda_sources)
      set(ANGIO_CUDA_ENABLED ON)
    elseif(NOT CMAKE_CUDA_COMPILER AND ANGIO_CUDA STREQUAL "ON")
      message(FATAL_ERROR "ANGIO_CUDA is ON, but there is no working nvcc. Install the CUDA toolkit "
        "(12.0 or newer), or point CUDACXX at nvcc, or configure with -DANGIO_CUDA=OFF")
    endif()
  endif()
endif()

if(ANGIO_CUDA_ENABLED)
  set(CMAKE_CUDA_ARCHITECTURES ${angio_architectures})
  enable_language(CUDA)
  if(CMAKE_CUDA_COMPILER_VERSION VERSION_LESS 12.0)
    message(FATAL_ERROR "CUDA ${CMAKE_CUDA_COMPILER_VERSION} is too old (it has no C++20). Install "
      "12.0 or newer, or configure with -DANGIO_CUDA=OFF")
  endif()
  # The CUDA standard, in one place. CMake 3.25 does not know nvcc's flag for C++20 (3.26 does).
  if(NOT CMAKE_CUDA20_STANDARD_COMPILE_OPTION)
    set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION "-std=c++20")
    set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION "-std=c++20")
    list(APPEND CMAKE_CUDA20_COMPILE_FEATURES "cuda_std_20")
    list(APPEND CMAKE_CUDA_COMPILE_FEATURES "cuda_std_20")
  endif()
  set(CMAKE_CUDA_STANDARD 20)
  set(CMAKE_CUDA_STANDARD_REQUIRED ON)
  set(CMAKE_CUDA_EXTENSIONS OFF)
  message(STATUS "CUDA: nvcc ${CMAKE_CUDA_COMPILER_VERSION}, for ${angio_architectures}")
elseif(angio_cuda_sources)
  message(STATUS "CUDA: not used (ANGIO_CUDA is OFF, or there is no nvcc, or no GPU, without which "
    "ANGIO_CUDA_ARCHITECTURES must name some)")
endif()

# angio_add_cuda_sources(TARGET FILES...)
# Adds .cu files to a target and defines ANGIO_HAS_CUDA for its sources; does nothing without CUDA.
function(angio_add_cuda_sources target)
  if(NOT ANGIO_CUDA_ENABLED)
    return()
  endif()
  target_sources(${target} PRIVATE ${ARGN})
  target_compile_definitions(${target} PRIVATE ANGIO_HAS_CUDA)
  set_target_properties(${target} PROPERTIES CUDA_RUNTIME_LIBRARY Static)
  target_compile_options(${target} PRIVATE
    $<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=-Wall,-Wextra>
    $<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${ANGIO_WARNINGS_AS_ERRORS}>>:-Werror=all-warnings>)
endfunction()
