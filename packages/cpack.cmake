# Packages for the Debian that builds them, one for each component of packages/install.cmake. scripts/release asks for
# them by PENUMBRA_PACKAGES=ON and the prefix /usr, with which libraries go where Debian has those of its processor.
file(STRINGS /etc/os-release release REGEX "^VERSION_ID=")
string(REGEX REPLACE "[^0-9.]" "" release "${release}")

set(CPACK_PACKAGE_NAME penumbra)
set(CPACK_PACKAGE_VENDOR Penumbra)
set(CPACK_PACKAGE_CONTACT ${PENUMBRA_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL player programs library development documents)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
# The newer Debian has the newer package, so that an upgrade of the system replaces it.
set(CPACK_DEBIAN_PACKAGE_RELEASE 1+deb${release})
set(version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(about "Penumbra gives animated characters and cloth soft self-shadows from
environment light, with any material, in real time. It ray-traces what every
vertex sees in every frame, learns how that follows from the pose, and packs
what it learned into an asset.")

set(CPACK_DEBIAN_PLAYER_PACKAGE_NAME penumbra-player)
set(CPACK_DEBIAN_PLAYER_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PLAYER_PACKAGE_SHLIBDEPS ON)
# It opens these at run time: without a GPU it draws by the software of Mesa.
set(CPACK_DEBIAN_PLAYER_PACKAGE_DEPENDS libegl1)
set(CPACK_DEBIAN_PLAYER_PACKAGE_RECOMMENDS "libgl1, libgl1-mesa-dri")
set(CPACK_COMPONENT_PLAYER_DESCRIPTION "soft self-shadows of characters: player
${about}
This package has the player, which draws and times assets, in a window or not.")

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME penumbra)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "python3, penumbra-player (= ${version})")
# The farm imports these.
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "python3-h5py, python3-numpy, python3-pil, python3-yaml")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SUGGESTS "blender, npm, penumbra-doc, snakemake")
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "soft self-shadows of characters: bake, fit and pack
${about}
This package has the programs that make assets, those that run many of them on
a farm, and the add-on for Blender.")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libpenumbra${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
# CPack's own are those of older Debians, which called ldconfig.
set(debian ${CMAKE_CURRENT_BINARY_DIR}/debian)
file(CONFIGURE OUTPUT ${debian}/triggers CONTENT "activate-noawait ldconfig\n")
file(CONFIGURE OUTPUT ${debian}/shlibs CONTENT
     "libpenumbra ${PROJECT_VERSION_MAJOR} libpenumbra${PROJECT_VERSION_MAJOR} (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${debian}/triggers ${debian}/shlibs)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "soft self-shadows of characters: library for engines
${about}
This package has the library by which engines evaluate assets.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libpenumbra-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libpenumbra${PROJECT_VERSION_MAJOR} (= ${version})")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "soft self-shadows of characters: headers
${about}
This package has what compiles and links with the library: its header, shaders,
package files and the static library.")

set(CPACK_DEBIAN_DOCUMENTS_PACKAGE_NAME penumbra-doc)
set(CPACK_DEBIAN_DOCUMENTS_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOCUMENTS_PACKAGE_ARCHITECTURE all)
set(CPACK_COMPONENT_DOCUMENTS_DESCRIPTION "soft self-shadows of characters: documents
${about}
This package has the documents, with their pictures.")

# Debian wants this of every package: its licence, its changes, and where lintian is wrong.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC) # SOURCE_DATE_EPOCH counts where that is set
find_program(GZIP gzip REQUIRED)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
    string(TOUPPER ${component} key)
    set(package ${CPACK_DEBIAN_${key}_PACKAGE_NAME})
    set(place share/doc/${package})
    file(CONFIGURE OUTPUT ${debian}/${package}/changelog.Debian CONTENT "penumbra (${version}) unstable; urgency=medium

  * Version ${PROJECT_VERSION}; CHANGELOG.md of penumbra-doc says what is new.

 -- ${PENUMBRA_MAINTAINER}  ${date}
")
    execute_process(COMMAND ${GZIP} -9nkf ${debian}/${package}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
    install(FILES ${debian}/${package}/changelog.Debian.gz packages/debian/copyright DESTINATION ${place}
            COMPONENT ${component})
    if(EXISTS ${PROJECT_SOURCE_DIR}/packages/debian/${package}.lintian-overrides)
        install(FILES packages/debian/${package}.lintian-overrides DESTINATION share/lintian/overrides RENAME ${package}
                COMPONENT ${component})
    endif()
endforeach()
include(CPack)
