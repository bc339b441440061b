# SPDX-License-Identifier: GPL-3.0-or-later
# A folder's headers are included by the folder's name ("http/router.hpp") and found only by targets that link it: what the
# folder's target adds to an include path is a directory that holds nothing but a link to the folder. A file that includes a
# folder which no arrow of its target leads to does not compile.
function(surfaced_headers target)
  cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME folder)
  set(staged ${CMAKE_CURRENT_BINARY_DIR}/include)
  file(MAKE_DIRECTORY ${staged})
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${staged}/${folder} SYMBOLIC)
  target_include_directories(${target} PUBLIC ${staged})
endfunction()
