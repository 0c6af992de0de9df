# nsdae_python_script(FILE): puts it into share/nsdae of the build tree and of the installation.
function(nsdae_python_script file)
  get_filename_component(name ${file} NAME)
  set(built ${PROJECT_BINARY_DIR}/share/nsdae/${name})
  configure_file(${file} ${built} @ONLY)
  install(FILES ${built} DESTINATION ${CMAKE_INSTALL_DATADIR}/nsdae)
endfunction()

# nsdae_python_tool(TOOL SCRIPT MODULES PACKAGES): a program of that name that runs the script with
# a Python that can import the modules; the packages are what Debian calls them.
function(nsdae_python_tool TOOL script TOOL_MODULES TOOL_PACKAGES)
  get_filename_component(name ${script} NAME)
  set(SCRIPT_INSTALLED ${CMAKE_INSTALL_DATADIR}/nsdae/${name})
  set(SCRIPT_BUILT share/nsdae/${name})
  nsdae_python_script(${script})
  configure_file(${PROJECT_SOURCE_DIR}/drivers/python/launcher.in ${PROJECT_BINARY_DIR}/bin/${TOOL}
    @ONLY FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
                           WORLD_READ WORLD_EXECUTE)
  install(PROGRAMS ${PROJECT_BINARY_DIR}/bin/${TOOL} DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
