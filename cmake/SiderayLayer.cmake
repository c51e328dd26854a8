# sideray_options(TARGET): the warnings and sanitizers that every target of ours is built with.
function(sideray_options target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion
    # As g++ understands them: clang's also count signs as conversions, and double{f}, a promotion that is wanted.
    $<$<COMPILE_LANGUAGE:CXX>:$<IF:$<CXX_COMPILER_ID:Clang>,-Wno-sign-conversion,-Wdouble-promotion>>
    $<$<COMPILE_LANGUAGE:CXX>:-Wold-style-cast>
    # Same source, same bits: hits are recomputed without fused multiply-add, whatever the target machine.
    -ffp-contract=off)
  if(CMAKE_UNITY_BUILD)
    # Of names in other files, which are only joined to compile them faster.
    target_compile_options(${target} PRIVATE -Wno-shadow)
  endif()
  if(SIDERAY_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(SIDERAY_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${SIDERAY_SANITIZE} -fno-omit-frame-pointer
      -fno-sanitize-recover=all -fno-sanitize=enum)  # C hands over enums with any value: they are checked where they come in
    target_link_options(${target} PRIVATE -fsanitize=${SIDERAY_SANITIZE})
    # What g++ 12 finds in the flow of code that the sanitizers have rewritten is not to be relied on: it may warn, not stop.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-error -Wno-maybe-uninitialized>)
  endif()
endfunction()

# sideray_include_root(TARGET VISIBILITY NAME): TARGET includes the headers of the current folder, which is called NAME, as
# "NAME/folder/file.h". The include path holds that one folder, so a target cannot include what it does not depend on.
function(sideray_include_root target visibility name)
  set(root ${CMAKE_BINARY_DIR}/layers/${name})
  file(MAKE_DIRECTORY ${root})
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${root}/${name} SYMBOLIC)
  target_include_directories(${target} ${visibility} ${root})
endfunction()

# sideray_layer(NAME [SOURCES...] [DEPENDS ...] [WITHOUT FOLDERS OR FILES...]): the folder NAME and its sub-folders, but for
# what WITHOUT names, as the static library sideray_NAME.
function(sideray_layer name)
  cmake_parse_arguments(arg "" "" "DEPENDS;WITHOUT" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *.cpp *.h)
  foreach(without ${arg_WITHOUT})
    list(FILTER sources EXCLUDE REGEX "^${CMAKE_CURRENT_SOURCE_DIR}/${without}(/|$)")
  endforeach()
  add_library(sideray_${name} STATIC ${sources} ${arg_UNPARSED_ARGUMENTS})
  sideray_include_root(sideray_${name} PUBLIC ${name})
  target_link_libraries(sideray_${name} PUBLIC ${arg_DEPENDS})
  set_target_properties(sideray_${name} PROPERTIES LINKER_LANGUAGE CXX)
  sideray_options(sideray_${name})
endfunction()

# sideray_parse_once(TARGET HEADERS... | REUSE_FROM OTHER): where everything is built from nothing, headers that nearly every
# source of the target includes are parsed once; or not even that, where OTHER is compiled with the same options. Elsewhere
# each source shows that it includes what it uses.
function(sideray_parse_once target)
  if(NOT CMAKE_UNITY_BUILD)
    return()
  endif()
  if(ARGV1 STREQUAL "REUSE_FROM")
    target_precompile_headers(${target} REUSE_FROM ${ARGV2})
  else()
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# sideray_join(TARGET COUNT): joined sources are that many to a compilation rather than eight. Sources that all take JSON
# apart spend most of their time in its templates, which joined sources instantiate once.
function(sideray_join target count)
  set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE ${count})
endfunction()

# sideray_apart(FILES...): of the folder's sources, those with names of their own that others have too. They are compiled
# alone where CMAKE_UNITY_BUILD joins the rest, eight at a time (script/test where nothing is built yet).
function(sideray_apart)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# sideray_embed(VARIABLE OUT.cpp HEADER NAMESPACE FILES...): VARIABLE becomes the path of a source file that holds the text
# of FILES and defines NAMESPACE::source, which HEADER declares.
function(sideray_embed variable out header namespace)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/${out})
  add_custom_command(
    OUTPUT ${generated}
    COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/cmake/embed_text.py ${generated} ${header} ${namespace} ${ARGN}
    DEPENDS ${ARGN} ${CMAKE_SOURCE_DIR}/cmake/embed_text.py
    VERBATIM)
  # A library in one line is longer than what a compiler must accept.
  set_source_files_properties(${generated} PROPERTIES COMPILE_OPTIONS -Wno-overlength-strings)
  set(${variable} ${generated} PARENT_SCOPE)
endfunction()
