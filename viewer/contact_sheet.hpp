#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace angio::viewer {

/// Draws a case on one sheet, to be looked at: the scan's projections with the lumen's contour (or
/// the surface from three sides), the tree of lines with inlet, outlets and lesions named, the
/// diameter along the treated line, the balloon at peak, and what the program said. A part that is
/// not there says so in words, so a case whose run failed has a sheet, too.
///
/// @param case_folder  named for people: its name is the sheet's title
/// @param png          written atomically; the same case gives the same bytes on one machine
/// @param log          what the run printed; its last line explains a case without results; may be
///                     empty
/// @throws InputError (66) if it is a file, or neither a case nor one whose log is there; Error
/// (69)
///         if nothing can render here
void write_contact_sheet(const std::filesystem::path& case_folder, const std::filesystem::path& png,
                         const std::filesystem::path& log);

/// Writes a page of thumbnails of the sheets beside it, under the table of a collection.
///
/// @param sheets     file names, relative to the page
/// @param table_csv  a header and a row a case; empty: no table
void write_sheet_index(const std::filesystem::path& page, const std::vector<std::string>& sheets,
                       const std::filesystem::path& table_csv);

}  // namespace angio::viewer
