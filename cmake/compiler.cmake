# SPDX-License-Identifier: GPL-3.0-or-later
# Language level, warnings and reproducible floating point, for every target of the project.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

if((CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 12)
    OR (CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 14))
  message(FATAL_ERROR "${CMAKE_CXX_COMPILER} is ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}; C++20 as it is used "
    "here needs GCC 12 or Clang 14 at least: install one (apt-get install g++-12) and name it, CXX=g++-12, in a new build folder")
endif()

find_program(SURFACED_CCACHE ccache)
if(SURFACED_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SURFACED_CCACHE})
endif()

# Meshes must not depend on the machine that compiled the code: no contraction into fused
# multiply-adds, no fast-math. (CGAL brings -frounding-math for the files that use it.)
add_compile_options(-ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  add_compile_options(-Wno-unknown-warning-option -Wno-ignored-optimization-argument)
endif()
# GCC 12 folds double -> float -> double away where it has packed two of them into a vector; the test
# RoundingToFloat32.happens_in_every_coordinate shows it. Later versions are not trusted unseen.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(-fno-tree-slp-vectorize)
endif()
macro(surfaced_sanitize)
  add_compile_options(-fsanitize=${SURFACED_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
endmacro()
if(SURFACED_SANITIZE)
  add_link_options(-fsanitize=${SURFACED_SANITIZE})
  if(SURFACED_SANITIZE_CORE)
    surfaced_sanitize()
  endif()
endif()
if(SURFACED_FUZZ)  # what libFuzzer steers by
  add_compile_options(-fsanitize=fuzzer-no-link -fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/tests/fuzz/not_ours.txt)
endif()

# One target carries the warnings, so that code of other projects compiled here goes without.
add_library(surfaced_warnings INTERFACE)
target_compile_options(surfaced_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast
  -Wnon-virtual-dtor -Woverloaded-virtual $<$<BOOL:${SURFACED_WERROR}>:-Werror>
  # GCC 12 sees an overlap in every "literal" + string (its bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
