# Everything that comes from Debian; the names of the packages stand in packages.txt.
# CGAL asks for a build type and changes flags globally unless told not to.
set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)
find_package(CGAL REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Threads REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(PkgConfig REQUIRED)
# The package's Cflags carry macros (OpenSSL, zlib, brotli) that change the layout of its classes.
pkg_check_modules(httplib REQUIRED IMPORTED_TARGET cpp-httplib)
find_path(DRACO_INCLUDE_DIR draco/core/draco_types.h REQUIRED)
find_library(DRACO_LIBRARY draco REQUIRED)
add_library(draco_codec INTERFACE)
target_include_directories(draco_codec SYSTEM INTERFACE ${DRACO_INCLUDE_DIR})
target_link_libraries(draco_codec INTERFACE ${DRACO_LIBRARY})
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)
