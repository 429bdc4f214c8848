#pragma once

#include <string>

namespace angio::viewer {

/// The report as a PDF on A4 paper: its words, cards, tables, pictures and charts in their order,
/// without what moves (the scene, the slider). The fonts are in it; no time stamp is.
///
/// @param page     report/index.html, as write_report writes it
/// @param name     of the case; the document's title is the page's heading, and that
/// @param version  of the program
/// @return the whole file
/// @throws InputError if a picture of the page is damaged; IoError if there is no memory for it
std::string report_pdf(const std::string& page, const std::string& name,
                       const std::string& version);

}  // namespace angio::viewer
