# Finds the fonts that figures are drawn with and embeds them into a target.
#
# They come from the Debian packages fonts-inter and fonts-dejavu-core. A release of fonts-inter that brings only the
# variable font serves as well: the weight is then set on its axis. PLANTLOOP_FONT_FOLDER names a folder to look in first.
include_guard()

set(PLANTLOOP_FONT_FOLDER "" CACHE PATH "a folder with Inter and DejaVu Sans, searched before the system's")

# find_font(variable file...): the first of these file names found below the font folders.
function(find_font variable)
  foreach(name ${ARGN})
    foreach(folder ${PLANTLOOP_FONT_FOLDER} /usr/share/fonts /usr/local/share/fonts)
      file(GLOB_RECURSE found LIST_DIRECTORIES false ${folder}/${name})
      if(found)
        list(SORT found)
        list(GET found 0 found)
        set(${variable} ${found} PARENT_SCOPE)
        return()
      endif()
    endforeach()
  endforeach()
  list(GET ARGN 0 wanted)
  message(FATAL_ERROR "The font file ${wanted} was not found. On Debian and Ubuntu: apt install fonts-inter fonts-dejavu-core")
endfunction()

# embed_fonts(target): adds a generated source with the bytes, weights and SHA-256 of the fonts.
function(embed_fonts target)
  set(variable_inter InterVariable.ttf Inter.var.ttf Inter-roman.var.ttf "Inter[[]opsz,wght[]].ttf" "InterVariable*.ttf")
  find_font(FONT_TEXT Inter-Regular.otf Inter-Regular.ttf ${variable_inter})
  find_font(FONT_STRONG Inter-SemiBold.otf Inter-SemiBold.ttf ${variable_inter})
  find_font(FONT_FALLBACK DejaVuSans.ttf)
  foreach(font TEXT STRONG FALLBACK)
    file(SHA256 ${FONT_${font}} FONT_${font}_SHA256)
  endforeach()
  set(FONT_TEXT_WEIGHT 0)
  set(FONT_STRONG_WEIGHT 0)
  if(FONT_TEXT MATCHES "[Vv]ar|wght")
    set(FONT_TEXT_WEIGHT 400)
  endif()
  if(FONT_STRONG MATCHES "[Vv]ar|wght")
    set(FONT_STRONG_WEIGHT 600)
  endif()
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/embedded_fonts.cpp)
  configure_file(${CMAKE_SOURCE_DIR}/render/text/embedded_fonts.cpp.in ${generated} @ONLY)
  set_source_files_properties(${generated} PROPERTIES OBJECT_DEPENDS "${FONT_TEXT};${FONT_STRONG};${FONT_FALLBACK}")
  target_sources(${target} PRIVATE ${generated})
endfunction()
