# What is installed, and what `cpack` makes of it: a Debian package, which says which libraries it needs, and
# an archive, which brings them along and runs from any folder.
include(GNUInstallDirs)

# Where the archive keeps its libraries; the Debian package has none there.
set_target_properties(angio PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}/angio")
# As RPATH, not RUNPATH: the libraries find each other by it, too.
target_link_options(angio PRIVATE LINKER:--disable-new-dtags)
install(TARGETS angio_film_codecs LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/angio COMPONENT program)
set_target_properties(angio_film_codecs PROPERTIES INSTALL_RPATH "$ORIGIN")
install(TARGETS angio RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
set(described ${PROJECT_BINARY_DIR}/share)
install(FILES ${described}/angio.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${described}/angio.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME angio COMPONENT program)
install(FILES ${described}/_angio DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions
  COMPONENT program)
install(FILES ${described}/angio.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
  COMPONENT program)
# Each command as a module of 3D Slicer: a folder for its "Additional module paths".
set(slicer_commands run segment centerline mesh simulate report convert film figure fit inflate recommend)
foreach(command IN LISTS slicer_commands)
  install(CODE "
    set(modules \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/angio/slicer\")
    file(MAKE_DIRECTORY \"\${modules}\")
    file(RELATIVE_PATH program \"\${modules}\"
      \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}/angio\")
    file(CREATE_LINK \"\${program}\" \"\${modules}/angio-${command}\" SYMBOLIC)"
    COMPONENT program)
endforeach()
install(FILES ${described}/angio.spdx DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright COMPONENT program)

# All libraries but those of the compiler and of glibc, which a system has, and fits to each other.
install(CODE "
  file(GET_RUNTIME_DEPENDENCIES EXECUTABLES \"$<TARGET_FILE:angio>\"
    MODULES \"$<TARGET_FILE:angio_film_codecs>\"
    RESOLVED_DEPENDENCIES_VAR libraries
    PRE_EXCLUDE_REGEXES \"^ld-linux\" \"^lib(c|m|dl|rt|pthread|resolv|gcc_s|stdc\\\\+\\\\+)\\\\.so\")
  file(INSTALL DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/angio\"
    TYPE SHARED_LIBRARY FOLLOW_SYMLINK_CHAIN FILES \${libraries})
  # A library with a path of its own (Open MPI's) is not looked for beside the others.
  file(GLOB installed \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/angio/*\")
  foreach(library IN LISTS installed)
    if(NOT IS_SYMLINK \"\${library}\")
      file(RPATH_REMOVE FILE \"\${library}\")
    endif()
  endforeach()"
  COMPONENT libraries EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB TGZ)
set(CPACK_PACKAGE_NAME angio)
set(CPACK_PACKAGE_VENDOR angio)
set(CPACK_PACKAGE_CONTACT "the angio authors <angio@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "simulate a balloon angioplasty in a patient's angiography")
set(CPACK_PACKAGE_DESCRIPTION "From a rotational angiography to what a balloon does to the artery:
segmentation, centreline, meshes, simulation and a report. Research software, not a medical device.")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Pictures where there is no screen.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libgl1-mesa-dri, xvfb")
set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/package_components.cmake)
include(CPack)
