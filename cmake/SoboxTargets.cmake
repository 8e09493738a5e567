# A folder is a library: sobox_library(NAME LINKS ...) builds every source of the folder it stands
# in, and LINKS is the complete list of what that folder may know.
function(sobox_library name)
  cmake_parse_arguments(arg "" "" "LINKS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.c)
  add_library(sobox_${name} STATIC ${sources})
  target_link_libraries(sobox_${name} PUBLIC ${arg_LINKS} PRIVATE sobox_options)
endfunction()

# A program: sobox_program(sobox-worker main.c LINKS ...). All programs land in build/bin. Those that a
# machine needs to help others are packaged apart from those of who wants to know something.
set(SOBOX_NODE_PROGRAMS sobox-worker sobox-hub)
function(sobox_program name source)
  cmake_parse_arguments(arg "" "" "LINKS" ${ARGN})
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE ${arg_LINKS} sobox_options)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
  set(component main)
  if(name IN_LIST SOBOX_NODE_PROGRAMS)
    set(component node)
  endif()
  install(TARGETS ${name} RUNTIME COMPONENT ${component})
endfunction()

# One test program for each *_test.c of tests/unit/FOLDER, linked with the library it mirrors:
# sobox_unit_tests(common/numeric LINKS sobox_numeric) gives the tests common/numeric/box, ...
# A *_net_test.c opens sockets: it runs in a network of its own, made by tests/netns.
function(sobox_unit_tests folder)
  cmake_parse_arguments(arg "" "" "LINKS;LABELS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*_test.c)
  foreach(source IN LISTS sources)
    get_filename_component(module ${source} NAME_WE)
    string(REGEX REPLACE "_test$" "" module ${module})
    string(REPLACE "/" "_" target "test_${folder}_${module}")
    add_executable(${target} ${source})
    target_link_libraries(${target} PRIVATE ${arg_LINKS} PkgConfig::CMOCKA sobox_options)
    target_compile_definitions(${target} PRIVATE
      SOBOX_SOURCE_DIR="${CMAKE_SOURCE_DIR}" SOBOX_BINARY_DIR="${CMAKE_BINARY_DIR}")
    set(wrapper)
    if(module MATCHES "_net$")
      set(wrapper ${CMAKE_SOURCE_DIR}/tests/netns)
    endif()
    add_test(NAME ${folder}/${module}
      COMMAND ${wrapper} ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${target}>)
    set_tests_properties(${folder}/${module} PROPERTIES TIMEOUT 1500 LABELS "${arg_LABELS}")
  endforeach()
endfunction()
