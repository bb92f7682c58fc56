# Runs a diagram, writes its figures and its data to a folder and says where they are.
#
#   cmake -D PROGRAM=... -D DIAGRAM=... -D FOLDER=... -D STAMP=... -P demo.cmake
#
# STAMP is a file to be touched: a figure that is older was not written by this run.
get_filename_component(name ${DIAGRAM} NAME_WE)
file(TOUCH ${STAMP})
execute_process(
  COMMAND ${PROGRAM} run ${DIAGRAM} --figures ${FOLDER} --out ${FOLDER}/${name}.csv COMMAND_ECHO STDOUT RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "plantloop run ended with status ${status}")
endif()

file(GLOB figures ${FOLDER}/*.png)
set(written ${FOLDER}/${name}.csv)
foreach(figure ${figures})
  if(${figure} IS_NEWER_THAN ${STAMP})
    list(APPEND written ${figure})
  endif()
endforeach()
list(LENGTH written count)
if(count EQUAL 1)
  message(FATAL_ERROR "plantloop run wrote no figure to ${FOLDER}")
endif()
list(JOIN written "\n  " written)
message("The figure and its data are on disk:\n  ${written}")
