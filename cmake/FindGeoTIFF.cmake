# GeoTIFF::geotiff, from libgeotiff-dev, which brings no CMake files of its own.
find_path(GeoTIFF_INCLUDE_DIR geotiffio.h PATH_SUFFIXES geotiff)
find_library(GeoTIFF_LIBRARY geotiff)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(GeoTIFF REQUIRED_VARS GeoTIFF_LIBRARY GeoTIFF_INCLUDE_DIR)
if(GeoTIFF_FOUND AND NOT TARGET GeoTIFF::geotiff)
  add_library(GeoTIFF::geotiff UNKNOWN IMPORTED)
  set_target_properties(GeoTIFF::geotiff PROPERTIES
    IMPORTED_LOCATION ${GeoTIFF_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${GeoTIFF_INCLUDE_DIR})
endif()
mark_as_advanced(GeoTIFF_INCLUDE_DIR GeoTIFF_LIBRARY)
