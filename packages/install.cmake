# `cmake --install build/release --prefix DIR [--component NAME]` copies, by component:
#   player       penumbra-player, and the materials that its window offers
#   programs     the other three programs, `penumbra`, the farm and the add-on for Blender
#   library      libpenumbra.so (runtime/CMakeLists.txt has this one and the next)
#   development  its header, package files and static library
#   documents    README and docs
# The tree can be moved as a whole. packages/cpack.cmake makes packages of the same components.

# A user needs these commands, modules and folders of scripts/. One that is not there is left out.
set(PENUMBRA_SCRIPT_COMMANDS penumbra setup)
set(PENUMBRA_SCRIPT_MODULES usage.py)
set(PENUMBRA_SCRIPT_FOLDERS make farm)

set(scripts ${CMAKE_INSTALL_DATADIR}/penumbra/scripts)
foreach(kind COMMANDS MODULES FOLDERS)
    foreach(name IN LISTS PENUMBRA_SCRIPT_${kind})
        set(path ${PROJECT_SOURCE_DIR}/scripts/${name})
        if(NOT EXISTS ${path})
            continue()
        elseif(kind STREQUAL COMMANDS)
            install(PROGRAMS ${path} DESTINATION ${scripts} COMPONENT programs)
        elseif(kind STREQUAL MODULES)
            install(FILES ${path} DESTINATION ${scripts} COMPONENT programs)
        else()
            install(DIRECTORY ${path} DESTINATION ${scripts} COMPONENT programs USE_SOURCE_PERMISSIONS
                    PATTERN __pycache__ EXCLUDE)
        endif()
    endforeach()
endforeach()

# Writes the manual page of a program, which says what the program itself says of its options.
function(penumbra_manual_page name path component)
    set(folder \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1)
    install(CODE "file(MAKE_DIRECTORY ${folder})
        execute_process(COMMAND ${PROJECT_SOURCE_DIR}/packages/man_page ${path} --version ${PROJECT_VERSION}
                        -o ${folder}/${name}.1.gz COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
endfunction()

install(TARGETS penumbra-player COMPONENT player)
if(PENUMBRA_MATERIALS)
    install(FILES ${PENUMBRA_MATERIALS} DESTINATION ${CMAKE_INSTALL_DATADIR}/penumbra COMPONENT player)
endif()
penumbra_manual_page(penumbra-player $<TARGET_FILE:penumbra-player> player)
foreach(program penumbra-bake penumbra-fit penumbra-pack)
    install(TARGETS ${program} COMPONENT programs)
    penumbra_manual_page(${program} $<TARGET_FILE:${program}> programs)
endforeach()

# `penumbra` finds its modules beside the file that the link leads to.
if(EXISTS ${PROJECT_SOURCE_DIR}/scripts/penumbra)
    file(RELATIVE_PATH to_scripts ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/penumbra/scripts)
    set(folder \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR})
    install(CODE "file(MAKE_DIRECTORY ${folder})
        file(CREATE_LINK ${to_scripts}/penumbra ${folder}/penumbra SYMBOLIC)" COMPONENT programs)
    penumbra_manual_page(penumbra ${PROJECT_SOURCE_DIR}/scripts/penumbra programs)
endif()

set(folder \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/penumbra)
install(CODE "file(MAKE_DIRECTORY ${folder})
    execute_process(COMMAND ${PROJECT_SOURCE_DIR}/scripts/blender/make_zip -o ${folder}/penumbra_addon.zip
                    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)" COMPONENT programs)

set(documents ${CMAKE_INSTALL_DOCDIR})
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md
        DESTINATION ${documents} COMPONENT documents)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${documents} COMPONENT documents)
install(FILES ${PROJECT_SOURCE_DIR}/formats/README.md DESTINATION ${documents}/formats COMPONENT documents)
