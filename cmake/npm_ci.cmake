# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the npm packages of a folder by its lock file, and says what to do where that fails.
#   cmake -DNPM=npm -DFOLDER=server/web -P cmake/npm_ci.cmake
# Two tries a package instead of npm's three with pauses of a minute: without a network that is known at once.
execute_process(
  COMMAND ${NPM} ci --no-audit --no-fund --ignore-scripts --loglevel=http
    --fetch-retries=1 --fetch-retry-mintimeout=1000 --fetch-retry-maxtimeout=5000
  WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "npm could not install the packages of ${FOLDER}: is there a network, and does `npm config get registry` "
    "name a registry that answers? The daemon without the viewer's page needs none of them: -DSURFACED_VIEWER=OFF "
    "(CMAKE_ARGS=-DSURFACED_VIEWER=OFF ./dev run).")
endif()
