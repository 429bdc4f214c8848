# CUDA, decided in one place. Everything builds and runs without it.
#
# ANGIO_CUDA  AUTO: used if nvcc is there. ON: an error if it is not. OFF: never.
#
# The language is enabled here, at file scope of the top directory, as CMake asks; only if there is
# something to compile with it, because finding a CUDA compiler takes seconds.
set(ANGIO_CUDA "AUTO" CACHE STRING "CUDA backend: AUTO, ON or OFF")
set_property(CACHE ANGIO_CUDA PROPERTY STRINGS AUTO ON OFF)
if(NOT ANGIO_CUDA MATCHES "^(AUTO|ON|OFF)$")
  message(FATAL_ERROR "ANGIO_CUDA is ${ANGIO_CUDA}, but must be AUTO, ON or OFF")
endif()

file(GLOB_RECURSE angio_cuda_sources ${PROJECT_SOURCE_DIR}/simulation/*.cu)
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
  if(angio_cuda_sources OR ANGIO_CUDA STREQUAL "ON")
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
  # Turing to Hopper as machine code, and Hopper's PTX for what comes after.
  set(ANGIO_CUDA_ARCHITECTURES 75-real 80-real 86-real 89-real 90 CACHE STRING
    "GPU architectures to compile for (see CMAKE_CUDA_ARCHITECTURES)")
  set(CMAKE_CUDA_ARCHITECTURES ${ANGIO_CUDA_ARCHITECTURES})
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
  message(STATUS "CUDA: nvcc ${CMAKE_CUDA_COMPILER_VERSION}, for ${ANGIO_CUDA_ARCHITECTURES}")
elseif(angio_cuda_sources)
  message(STATUS "CUDA: not used (no nvcc, or ANGIO_CUDA is OFF)")
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
