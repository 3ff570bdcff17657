# cmake --install: programs (component programs); headers, static libraries and the CMake package
# (component dev), from which another project takes what it asks for and no more:
#   find_package(stria REQUIRED COMPONENTS registration)
#   target_link_libraries(mine PRIVATE stria::registration)
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stria)

foreach(program stria striad-sim)
    if(TARGET ${program})
        install(TARGETS ${program} RUNTIME COMPONENT programs)
    endif()
endforeach()

file(GLOB_RECURSE headers RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS
     ${PROJECT_SOURCE_DIR}/firmware/*.h ${PROJECT_SOURCE_DIR}/host/*.h
     ${PROJECT_SOURCE_DIR}/calib/*.h ${PROJECT_SOURCE_DIR}/sim/*.h)
list(FILTER headers EXCLUDE REGEX "^host/cli/")
foreach(header IN LISTS headers)
    # A header that shows a third-party type is its folder's own (tests/structure holds that).
    file(STRINGS ${header} third_party LIMIT_COUNT 1 REGEX
         "#include (\".*_generated\\.h\"|<(opencv2|ceres|flatbuffers|tbb|embree3|CLI|nlohmann|toml)[/+])")
    if(third_party)
        continue()
    endif()
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION include/stria/${folder} COMPONENT dev)
endforeach()

# How another project finds what a library of ours links: "pattern|find_dependency arguments", or
# "pattern|pkg-config NAME MODULE" for the target PkgConfig::NAME.
set(packages
    "^Eigen3::Eigen$|Eigen3 3.4"
    "^Threads::Threads$|Threads"
    "^TBB::tbb|TBB"
    "^PNG::PNG$|PNG"
    "^JPEG::JPEG$|JPEG"
    "^TIFF::TIFF$|TIFF"
    "^Ceres::ceres$|Ceres"
    "^opencv_|OpenCV COMPONENTS core imgproc calib3d objdetect aruco"
    "^embree$|embree 3"
    "^flatbuffers::|FlatBuffers CONFIG"
    "^CLI11::CLI11$|CLI11"
    "^tomlplusplus::tomlplusplus$|tomlplusplus"
    "^nlohmann_json::nlohmann_json$|nlohmann_json"
    "^PkgConfig::ZSTD$|pkg-config ZSTD libzstd"
    "^PkgConfig::HWY$|pkg-config HWY libhwy")

set(STRIA_PACKAGE_COMPONENTS "")
set(STRIA_PACKAGE_DEPENDENCIES "")
get_property(libraries GLOBAL PROPERTY STRIA_LIBRARIES)
foreach(library IN LISTS libraries)
    get_target_property(folder ${library} SOURCE_DIR)
    if(folder MATCHES "/host/cli$")
        continue()  # the program's own, not for others
    endif()
    string(REGEX REPLACE "^stria_" "" component ${library})
    list(APPEND STRIA_PACKAGE_COMPONENTS ${component})
    set_target_properties(${library} PROPERTIES EXPORT_NAME ${component})
    install(TARGETS ${library} EXPORT stria ARCHIVE COMPONENT dev)
    library_closure(${library} links)
    list(REMOVE_ITEM links ${libraries})
    set(found "")
    foreach(link IN LISTS links)
        set(known FALSE)
        foreach(entry IN LISTS packages)
            string(REGEX REPLACE "^(.*)\\|[^|]*$" "\\1" pattern "${entry}")
            string(REGEX REPLACE "^.*\\|" "" arguments "${entry}")
            if(link MATCHES "${pattern}")
                set(known TRUE)
                list(APPEND found "${arguments}")
            endif()
        endforeach()
        if(NOT known)
            message(FATAL_ERROR "cmake/install.cmake knows no package for ${link} (${library})")
        endif()
    endforeach()
    list(REMOVE_DUPLICATES found)
    string(APPEND STRIA_PACKAGE_DEPENDENCIES "set(stria_needs_${component} \"${found}\")\n")
endforeach()

install(EXPORT stria NAMESPACE stria:: FILE stria-targets.cmake DESTINATION ${package_dir}
        COMPONENT dev)
configure_package_config_file(cmake/stria-config.cmake.in ${PROJECT_BINARY_DIR}/stria-config.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/stria-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/stria-config.cmake
              ${PROJECT_BINARY_DIR}/stria-config-version.cmake
        DESTINATION ${package_dir} COMPONENT dev)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT programs)

# cpack -G DEB: one package a component.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the stria maintainers")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL programs dev)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME stria)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION
    "laser-stripe scanner: from calibration and scans to a measured mesh")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libstria-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libtbb-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS
    "libpng-dev, libjpeg-dev, libtiff-dev, libtomlplusplus-dev, nlohmann-json3-dev, libzstd-dev, libhwy-dev, libflatbuffers-dev, libembree-dev, libceres-dev, libopencv-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION "laser-stripe scanner: headers and static libraries")
include(CPack)
