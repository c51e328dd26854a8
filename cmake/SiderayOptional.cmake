# sideray_optional(OPTION WHAT): OPTION decides whether the part WHAT of the project is built: AUTO (where everything that it
# needs is installed), ON or OFF.
function(sideray_optional option what)
  set(${option} AUTO CACHE STRING "Build ${what}: AUTO, ON or OFF")
  set_property(CACHE ${option} PROPERTY STRINGS AUTO ON OFF)
endfunction()

# sideray_leave_out(OPTION WHAT OBSTACLE): says why the part is not built, and fails where OPTION is ON.
function(sideray_leave_out option what obstacle)
  if(${option} STREQUAL "AUTO")
    message(STATUS "${what} is left out: ${obstacle}")
  else()
    message(FATAL_ERROR "${option}=${${option}}, but ${obstacle}: install what is missing, or set AUTO or OFF")
  endif()
endfunction()
