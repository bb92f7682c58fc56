# Writes the pages of docs/ that are made from the declarations, where they differ.
#
#   cmake -D PROGRAM=plantloop -D FOLDER=docs -D SCRATCH=folder -P pages.cmake

# page(file command...): what the command prints is the page.
function(page file)
  execute_process(COMMAND ${PROGRAM} ${ARGN} OUTPUT_FILE ${SCRATCH}/${file} COMMAND_ERROR_IS_FATAL ANY)
  # A source tree that cannot be written is read by the tests as it is.
  file(COPY_FILE ${SCRATCH}/${file} ${FOLDER}/${file} ONLY_IF_DIFFERENT RESULT failure)
  if(failure)
    message(STATUS "docs/${file} was not brought up to date: ${failure}")
  endif()
endfunction()

page(blocks.md blocks --markdown)
page(diagram.schema.json schema)
page(checks.md check --list)
page(lua.md schema --functions)
