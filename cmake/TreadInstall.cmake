# cmake --install gives a tree in which another project finds tread with find_package(tread).
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tread)

install(TARGETS tread EXPORT treadTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY src/tread DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.hpp")
install(EXPORT treadTargets NAMESPACE tread:: DESTINATION ${package_dir})
write_basic_package_version_file(treadConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/treadConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/treadConfigVersion.cmake
              cmake/TreadDependencies.cmake cmake/FindGeoTIFF.cmake cmake/FindMuJoCo.cmake
              cmake/FindOpenCVModules.cmake
        DESTINATION ${package_dir})
install(DIRECTORY rigs robots worlds DESTINATION ${CMAKE_INSTALL_DATADIR}/tread)
if(TARGET tread_app)
  install(TARGETS tread_app DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
