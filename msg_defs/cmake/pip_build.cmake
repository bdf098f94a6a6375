# What a build against the PyPI builds of ROS 2 needs mended. A ROS installation never reads this file: setup.py (pip)
# and tools/colcon.sh name it in CMAKE_PROJECT_hybrid_dynamics_msgs_INCLUDE, and their Python in Python3_EXECUTABLE.

# 1. Find the prefix that the wheels were unpacked into: the virtual environment, or pip's isolated build environment.
execute_process(
  COMMAND "${Python3_EXECUTABLE}" -c
    "import ament_package, pathlib; print(pathlib.Path(ament_package.__file__).resolve().parents[4])"
  OUTPUT_VARIABLE wheels_prefix OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
message(STATUS "ROS 2 from wheels in ${wheels_prefix}")
list(PREPEND CMAKE_PREFIX_PATH "${wheels_prefix}")
set(ENV{AMENT_PREFIX_PATH} "${wheels_prefix}")

# 2. The wheels' targets *__rosidl_generator_py export include folders of the machine they were built on, which CMake
#    refuses because they do not exist here. Drop those once all targets are imported: at the end of configuration.
function(drop_missing_include_folders)
  get_property(targets DIRECTORY "${CMAKE_SOURCE_DIR}" PROPERTY IMPORTED_TARGETS)
  list(FILTER targets INCLUDE REGEX "__rosidl_generator_py$")
  foreach(target IN LISTS targets)
    get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
    set(existing "")
    foreach(folder IN LISTS folders)
      if(IS_DIRECTORY "${folder}")
        list(APPEND existing "${folder}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${existing}")
  endforeach()
endfunction()
cmake_language(DEFER CALL drop_missing_include_folders)

# 3. Type supports are some hundred small files below the same large headers: together they compile in a fraction of the
#    time. Those of rosidl_generator_c cannot be joined, their static names are the same in each. Nor can those of every
#    package: some declare what another one of their files defines.
function(join_type_supports)
  if(NOT PROJECT_NAME STREQUAL "hybrid_dynamics_msgs")
    return()
  endif()
  get_property(targets DIRECTORY "${CMAKE_SOURCE_DIR}" PROPERTY BUILDSYSTEM_TARGETS)
  list(FILTER targets INCLUDE REGEX "__rosidl_typesupport_.*(c|cpp)$")
  set_target_properties(${targets} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 10)
  # The stream from Python runs through none of these: they are compiled in three quarters of the time. A build that is
  # only tried has no type, and is not optimised at all.
  list(FILTER targets INCLUDE REGEX "_introspection_c$|_cpp$")
  foreach(target IN LISTS targets)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endforeach()
endfunction()
cmake_language(DEFER CALL join_type_supports)
