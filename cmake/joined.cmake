# SPDX-License-Identifier: GPL-3.0-or-later
# Files of a room compiled together, some at a time, so that the headers they share are read once: two thirds of the time of
# a small file. Within a room the names of anonymous namespaces are therefore told apart. Every file still includes what it
# uses; a build with -DSURFACED_JOINED=OFF (that of `./dev lint`) holds that.
option(SURFACED_JOINED "Compile small files of a room together" ON)

function(surfaced_joined target)  # surfaced_joined(TARGET [AT_A_TIME N] [ALONE FILE...])
  if(NOT SURFACED_JOINED)
    return()
  endif()
  cmake_parse_arguments(ARG "" "AT_A_TIME" "ALONE" ${ARGN})
  if(NOT ARG_AT_A_TIME)
    set(ARG_AT_A_TIME 12)
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(NOT source MATCHES "\\.cpp$" OR source IN_LIST ARG_ALONE)
      continue()
    endif()
    cmake_path(GET source PARENT_PATH room)
    string(MAKE_C_IDENTIFIER "room_${room}" room)
    math(EXPR count "0${count_${room}} + 1")
    set(count_${room} ${count})
    math(EXPR part "(${count} - 1) / ${ARG_AT_A_TIME}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room}_${part})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
