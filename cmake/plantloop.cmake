# The helpers that the folders' CMakeLists.txt use. Properties go on targets, never into global flags.
include_guard()
include(GNUInstallDirs)

set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

# What one folder finds, every folder may link; fmt is used in all of them.
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)
find_package(fmt REQUIRED)

# ccache when it is there; never required. Paths count from the source tree, so that clones and worktrees share what was compiled.
find_program(PLANTLOOP_CCACHE ccache)
if(PLANTLOOP_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${PLANTLOOP_CCACHE})
endif()

option(PLANTLOOP_WERROR "treat warnings as errors" ON)
set(PLANTLOOP_SANITIZE "" CACHE STRING "sanitizers, as in -fsanitize=...")

# plantloop_options: what every target of the project is compiled with.
add_library(plantloop_options INTERFACE)
target_compile_features(plantloop_options INTERFACE cxx_std_20)
target_include_directories(plantloop_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(plantloop_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-qual -Wno-missing-field-initializers
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # g++ 12 sees overlaps in "text" + std::string that are none (GCC PR 105651)
  -ffp-contract=off)  # group loops and scalar code must round alike; contraction is a pass, never the compiler's choice
if(PLANTLOOP_WERROR)
  target_compile_options(plantloop_options INTERFACE -Werror)
endif()
if(PLANTLOOP_SANITIZE)
  # g++ 12 finds a false one in std::regex when sanitizers are on.
  target_compile_options(plantloop_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_compile_options(plantloop_options INTERFACE -fsanitize=${PLANTLOOP_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(plantloop_options INTERFACE -fsanitize=${PLANTLOOP_SANITIZE})
endif()

# plantloop_library(name SOURCES a.cpp ... USES plantloop::base fmt::fmt ... [OBJECT])
#   makes the target plantloop_<name> with the alias plantloop::<name>. OBJECT keeps objects that only register themselves.
function(plantloop_library name)
  cmake_parse_arguments(ARG "OBJECT" "" "SOURCES;USES;PRIVATE_USES" ${ARGN})
  if(ARG_OBJECT)
    add_library(plantloop_${name} OBJECT ${ARG_SOURCES})
  else()
    add_library(plantloop_${name} STATIC ${ARG_SOURCES})
  endif()
  add_library(plantloop::${name} ALIAS plantloop_${name})
  target_link_libraries(plantloop_${name} PUBLIC plantloop_options ${ARG_USES} PRIVATE ${ARG_PRIVATE_USES})
endfunction()

# plantloop_test(name SOURCES a_test.cpp ... USES plantloop::base ...)
#   makes the executable <name>_test from GoogleTest sources and registers each of its tests with CTest.
#   Tests run in the source tree's root, so that they open diagrams by the names that a user types.
function(plantloop_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES" ${ARGN})
  find_package(GTest REQUIRED)
  include(GoogleTest)
  add_executable(${name}_test ${ARG_SOURCES})
  target_link_libraries(${name}_test PRIVATE plantloop_options ${ARG_USES} GTest::gmock GTest::gtest_main)
  gtest_discover_tests(${name}_test TEST_PREFIX "${name}." WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} DISCOVERY_MODE PRE_TEST
    DISCOVERY_TIMEOUT 60)
endfunction()
