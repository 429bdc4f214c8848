# cmake -D SOURCE_DIR=... -D OUTPUT=... -P write_commit.cmake
# Writes the header that names the commit which is built. It is touched only when the commit changes.
set(commit "$Format:%h$")  # git archive fills this in
if(commit MATCHES "Format")
  set(commit "")
  find_package(Git QUIET)
  if(Git_FOUND AND EXISTS ${SOURCE_DIR}/.git)
    execute_process(
      COMMAND ${GIT_EXECUTABLE} -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude *
      OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  endif()
endif()
set(text "#pragma once

namespace angio::pipeline {

/// The commit that was built, -dirty with changes of one's own; empty: not known.
inline constexpr const char* kCommit = \"${commit}\";

}  // namespace angio::pipeline
")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} before)
endif()
if(NOT before STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
