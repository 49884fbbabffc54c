# What a package installs, and the Debian package itself (`./run package`).
include(GNUInstallDirs)

install(TARGETS hecaton hecaton-agent hecaton-planner hecaton-arm-driver hecaton-world hecaton-supervisor hecaton-view
                hecaton-recorder hecaton-ros2
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY examples/client DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libhecaton-dev/examples COMPONENT client)
install(DIRECTORY examples/device DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libhecaton-dev/examples COMPONENT client
        PATTERN "*_test.cpp" EXCLUDE PATTERN "wrong_key.yaml" EXCLUDE)
install(DIRECTORY deploy/robots DESTINATION ${CMAKE_INSTALL_DATADIR}/hecaton)
install(DIRECTORY deploy/cells DESTINATION ${CMAKE_INSTALL_DATADIR}/hecaton)
install(DIRECTORY deploy/ros2 DESTINATION ${CMAKE_INSTALL_DATADIR}/hecaton)
install(DIRECTORY idl DESTINATION ${CMAKE_INSTALL_DATADIR}/hecaton FILES_MATCHING PATTERN "*.idl")
install(DIRECTORY deploy/container DESTINATION ${CMAKE_INSTALL_DATADIR}/hecaton USE_SOURCE_PERMISSIONS)
install(FILES "deploy/systemd/hecaton-agent@.service" DESTINATION lib/systemd/system)
# As they are here, for they refer to each other; `doc_links` looks that they refer to nothing else.
install(FILES README.md ARCHITECTURE.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/hecaton)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/hecaton PATTERN "*.py" EXCLUDE PATTERN "docs/api" EXCLUDE)
install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/hecaton)

# Each program of several commands writes its own man page and completion. COMPONENT: the package, if not the main one.
find_program(HECATON_GZIP gzip REQUIRED)
function(hecaton_install_shell_files program)
  install(CODE "
    execute_process(COMMAND $<TARGET_FILE:${program}> completion bash
                    OUTPUT_FILE ${CMAKE_BINARY_DIR}/${program}.bash COMMAND_ERROR_IS_FATAL ANY)
    execute_process(COMMAND $<TARGET_FILE:${program}> man COMMAND ${HECATON_GZIP} -9n
                    OUTPUT_FILE ${CMAKE_BINARY_DIR}/${program}.1.gz COMMAND_ERROR_IS_FATAL ANY)" ${ARGN})
  install(FILES ${CMAKE_BINARY_DIR}/${program}.bash RENAME ${program}
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions ${ARGN})
  install(FILES ${CMAKE_BINARY_DIR}/${program}.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 ${ARGN})
endfunction()
hecaton_install_shell_files(hecaton)
# A package of its own, which alone depends on NLopt, Open MPI and gnuplot.
if(HECATON_STRATEGIES)
  install(TARGETS hecaton-strategies RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT strategies)
  install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/hecaton-strategies COMPONENT strategies)
  hecaton_install_shell_files(hecaton-strategies COMPONENT strategies)
endif()
# The Python package installs itself: services/python.
if(HECATON_PYTHON_PACKAGE)
  install(DIRECTORY examples/python DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-hecaton/examples COMPONENT python)
  install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-hecaton COMPONENT python)
endif()

set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON) # a package does not wait for the tests to be built
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/package)
set(CPACK_PACKAGE_CONTACT "The Hecaton authors")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/deploy/package/postinst
                                       ${PROJECT_SOURCE_DIR}/deploy/package/prerm
                                       ${PROJECT_SOURCE_DIR}/deploy/package/postrm)
# hecaton, and hecaton-strategies with what the component has.
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME hecaton)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SUGGESTS hecaton-strategies)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_CONTROL_EXTRA ${CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA})
unset(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA)
set(CPACK_COMPONENT_UNSPECIFIED_DESCRIPTION ${PROJECT_DESCRIPTION})
set(CPACK_COMPONENT_STRATEGIES_DESCRIPTION "Motion strategies of robot arms that share a workspace, found off line")
set(CPACK_DEBIAN_STRATEGIES_PACKAGE_NAME hecaton-strategies)
set(CPACK_DEBIAN_STRATEGIES_PACKAGE_DEPENDS "openmpi-bin, gnuplot-nox | gnuplot")
set(CPACK_DEBIAN_STRATEGIES_PACKAGE_SUGGESTS hecaton)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Python package of Hecaton: drive a running cell, and plan without one")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-hecaton)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
get_property(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS GLOBAL PROPERTY HECATON_PYTHON_DEPENDS)
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS hecaton) # robots by name
set(CPACK_COMPONENT_CLIENT_DESCRIPTION "C++ client library of Hecaton, and headers of device plug-ins: shared library, CMake package, pkg-config file")
set(CPACK_DEBIAN_CLIENT_PACKAGE_SUGGESTS libeigen3-dev)
set(CPACK_DEBIAN_CLIENT_PACKAGE_NAME libhecaton-dev)
set(CPACK_DEBIAN_CLIENT_PACKAGE_SECTION libdevel)
include(CPack)
