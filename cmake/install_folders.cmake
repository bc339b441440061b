# SPDX-License-Identifier: GPL-3.0-or-later
# Whoever installs may have a umask that keeps others out; what is installed is for everybody. CMake gives files their
# permissions and has folders cut by the umask, CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS or not. So the prefix is made
# first where it is not there, and `surfaced_open_folders`, called last, opens the folders of the files below it that were
# not there before: how others' folders stand is theirs to say.
set(CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(open_folder "PERMISSIONS ${CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS}")
string(REPLACE ";" " " open_folder "${open_folder}")
install(CODE "
  if(NOT EXISTS \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    file(CHMOD \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\" ${open_folder})
  endif()
  file(GLOB surfaced_folders_before LIST_DIRECTORIES true \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/*\"
    \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/*/*\" \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/*/*/*\"
    \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/*/*/*/*\")" ALL_COMPONENTS)

function(surfaced_open_folders)
  install(CODE "
    cmake_policy(PUSH)
    cmake_policy(SET CMP0057 NEW)
    set(folders)
    foreach(folder IN LISTS CMAKE_INSTALL_MANIFEST_FILES)
      cmake_path(GET folder PARENT_PATH folder)
      cmake_path(IS_PREFIX CMAKE_INSTALL_PREFIX \"\${folder}\" below)
      while(below AND NOT folder STREQUAL CMAKE_INSTALL_PREFIX AND NOT folder IN_LIST folders)
        list(APPEND folders \"\${folder}\")
        cmake_path(GET folder PARENT_PATH folder)
        cmake_path(IS_PREFIX CMAKE_INSTALL_PREFIX \"\${folder}\" below)
      endwhile()
    endforeach()
    foreach(folder IN LISTS folders)
      if(NOT \"\$ENV{DESTDIR}\${folder}\" IN_LIST surfaced_folders_before)
        file(CHMOD \"\$ENV{DESTDIR}\${folder}\" ${open_folder})
      endif()
    endforeach()
    cmake_policy(POP)" ALL_COMPONENTS)
endfunction()
