#include "segmentation/detail/file_completeness.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"

namespace angio::segmentation::detail {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostHeaderBytes = std::size_t(1) << 20;
constexpr std::size_t kChunk = std::size_t(1) << 18;
constexpr std::uint64_t kMostValues = std::uint64_t(1) << 40;  ///< more is a damaged header

enum class Encoding { raw, deflated, text, hex, other };

/// Where a header says that its values are, and how many.
struct Layout {
  Encoding encoding = Encoding::raw;
  std::uint64_t value_count = 1;
  std::uint64_t value_bytes = 0;  ///< 0: of a type that is not known here
  std::vector<fs::path> files;    ///< each with an equal part of the values
  std::uint64_t offset = 0;       ///< of the values in each file
  std::uint64_t skipped = 0;      ///< bytes before the values, after decompression
  std::uint64_t lines = 0;        ///< before them, as the file is
};

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw InputError("cannot read " + file.filename().string() + " (truncated or damaged: " + why +
                   "). Copy or export it again");
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// Fields of a text header; names in lower case without blanks.
struct TextHeader {
  std::map<std::string, std::string> fields;
  std::vector<std::string> names_after;  ///< lines after a list of files is announced
  std::uint64_t end = 0;                 ///< the first byte after it
  bool is_ended = false;                 ///< by its own mark
  bool ends_in_newline = false;
  [[nodiscard]] std::string get(const std::string& name) const {
    const auto field = fields.find(name);
    return field == fields.end() ? std::string() : field->second;
  }
};

TextHeader read_header(const fs::path& path, bool is_nrrd) {
  std::ifstream file(path, std::ios::binary);
  TextHeader header;
  bool is_list = false;
  for (std::string line; header.end < kMostHeaderBytes && std::getline(file, line);) {
    header.ends_in_newline = !file.eof();
    header.end += line.size() + (header.ends_in_newline ? 1 : 0);
    line = trimmed(line);
    if (is_nrrd && line.empty()) {
      header.is_ended = header.ends_in_newline;
      break;
    }
    const auto mark = line.find_first_of(is_nrrd ? ":" : "=:");
    if (is_list) header.names_after.push_back(line);
    if (is_list || line.starts_with("#") || mark == std::string::npos) continue;
    std::string name = lower_case(line.substr(0, mark));
    std::erase(name, ' ');
    header.fields[name] = trimmed(line.substr(mark + 1));
    const bool names_data = name == (is_nrrd ? "datafile" : "elementdatafile");
    is_list = names_data && lower_case(header.fields[name]).starts_with("list");
    if (is_nrrd || !names_data || is_list) continue;
    header.is_ended = true;
    break;
  }
  return header;
}

std::uint64_t product_of(const std::string& sizes, const fs::path& path) {
  std::istringstream text(sizes);
  std::uint64_t product = 1;
  int count = 0;
  for (std::int64_t size = 0; text >> size; ++count) {
    if (size < 1 || std::uint64_t(size) > kMostValues / product)
      refuse(path, "a size in its header is impossible");
    product *= std::uint64_t(size);
  }
  if (count == 0) refuse(path, "its header states no size");
  return product;
}

/// The files that a field names: one, a list below it, or a numbered pattern.
std::vector<fs::path> files_of(const TextHeader& header, const std::string& field,
                               const fs::path& path) {
  std::vector<std::string> names;
  std::istringstream words(field);
  std::string pattern;
  long first = 0, last = 0, step = 1;
  if (lower_case(field).starts_with("list")) {
    for (const std::string& name : header.names_after)
      if (!name.empty()) names.push_back(name);
  } else if (field.find('%') != std::string::npos && words >> pattern >> first >> last) {
    if (!(words >> step) || step == 0) step = 1;
    const auto number_format = pattern.find('%');
    const auto letter = pattern.find_first_of("diuDIU", number_format);
    if (letter == std::string::npos) refuse(path, "its pattern of file names");
    const std::string digits = pattern.substr(number_format + 1, letter - number_format - 1);
    const auto width = std::size_t(std::min(20, std::atoi(digits.c_str())));
    for (long n = first; (step > 0 ? n <= last : n >= last) && names.size() < 65536; n += step) {
      std::string number = std::to_string(n);
      if (number.size() < width) number.insert(0, width - number.size(), '0');
      names.push_back(pattern.substr(0, number_format) + number + pattern.substr(letter + 1));
    }
  } else {
    names.push_back(field);
  }
  std::vector<fs::path> files;
  for (const std::string& name : names)
    files.push_back(fs::path(name).is_absolute() ? fs::path(name) : path.parent_path() / name);
  return files;
}

Layout meta_image_layout(const fs::path& path) {
  const TextHeader header = read_header(path, false);
  const std::string data = header.get("elementdatafile");
  if (data.empty()) refuse(path, "its header does not say where the voxels are");
  Layout layout;
  const std::string channels = header.get("elementnumberofchannels");
  layout.value_count =
      product_of(header.get("dimsize") + (channels.empty() ? "" : " " + channels), path);
  const std::map<std::string, int> bytes_of_type = {
      {"met_char", 1},      {"met_uchar", 1},      {"met_short", 2}, {"met_ushort", 2},
      {"met_int", 4},       {"met_uint", 4},       {"met_long", 4},  {"met_ulong", 4},
      {"met_long_long", 8}, {"met_ulong_long", 8}, {"met_float", 4}, {"met_double", 8}};
  const auto bytes = bytes_of_type.find(lower_case(header.get("elementtype")));
  if (bytes != bytes_of_type.end()) layout.value_bytes = std::uint64_t(bytes->second);
  if (lower_case(header.get("compresseddata")).starts_with("t"))
    layout.encoding = Encoding::deflated;
  else if (lower_case(header.get("binarydata")).starts_with("f"))
    layout.encoding = Encoding::text;
  // MetaIO takes a missing one for 0, and gives memory that was never written.
  if (layout.encoding == Encoding::deflated && !header.fields.contains("compresseddatasize"))
    refuse(path, "its header does not say how long its compressed voxels are");
  if (lower_case(data) == "local") {
    layout.files = {path};
    layout.offset = header.end;
    return layout;
  }
  layout.files = files_of(header, data, path);
  const std::string before = header.get("headersize");
  if (!before.empty() && before[0] != '-')
    layout.offset = std::strtoull(before.c_str(), nullptr, 10);
  return layout;
}

int nrrd_bytes(const std::string& type) {
  const std::array<std::pair<int, std::vector<std::string>>, 4> types{{
      {1, {"signed char", "int8", "int8_t", "uchar", "unsigned char", "uint8", "uint8_t"}},
      {2,
       {"short", "short int", "signed short", "signed short int", "int16", "int16_t", "ushort",
        "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
      {4,
       {"int", "signed int", "int32", "int32_t", "uint", "unsigned int", "uint32", "uint32_t",
        "float"}},
      {8,
       {"longlong", "long long", "long long int", "signed long long", "signed long long int",
        "int64", "int64_t", "ulonglong", "unsigned long long", "unsigned long long int", "uint64",
        "uint64_t", "double"}},
  }};
  for (const auto& [bytes, names] : types)
    if (std::find(names.begin(), names.end(), type) != names.end()) return bytes;
  return 0;
}

Layout nrrd_layout(const fs::path& path) {
  const TextHeader header = read_header(path, true);
  const std::string data = header.get("datafile");
  if (data.empty() ? !header.is_ended : !header.ends_in_newline)
    refuse(path, "its header ends early");
  Layout layout;
  layout.value_count = product_of(header.get("sizes"), path);
  layout.value_bytes = std::uint64_t(nrrd_bytes(lower_case(header.get("type"))));
  const std::string encoding = lower_case(header.get("encoding"));
  layout.encoding = encoding == "raw"                        ? Encoding::raw
                    : encoding == "gzip" || encoding == "gz" ? Encoding::deflated
                    : encoding == "ascii" || encoding == "text" || encoding == "txt"
                        ? Encoding::text
                    : encoding == "hex" ? Encoding::hex
                                        : Encoding::other;
  layout.files = data.empty() ? std::vector<fs::path>{path} : files_of(header, data, path);
  layout.offset = data.empty() ? header.end : 0;
  layout.lines = std::strtoull(header.get("lineskip").c_str(), nullptr, 10);
  const std::string skip = header.get("byteskip");
  if (!skip.empty() && skip[0] != '-') layout.skipped = std::strtoull(skip.c_str(), nullptr, 10);
  return layout;
}

int legacy_vtk_bytes(const std::string& type) {
  static const std::map<std::string, int> bytes_of_type{
      {"char", 1},          {"unsigned_char", 1}, {"short", 2},        {"unsigned_short", 2},
      {"int", 4},           {"unsigned_int", 4},  {"float", 4},        {"long", 8},
      {"unsigned_long", 8}, {"double", 8},        {"vtktypeint64", 8}, {"vtktypeuint64", 8}};
  const auto found = bytes_of_type.find(type);
  return found == bytes_of_type.end() ? 0 : found->second;
}

/// Of the first values at the points of VTK's legacy format; no files where it names none.
Layout legacy_vtk_layout(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  Layout layout;
  std::uint64_t points = 0;
  std::string line, word, name, type;
  for (std::uint64_t read = 0; read < kMostHeaderBytes && std::getline(file, line);) {
    read += line.size() + 1;
    std::istringstream words(lower_case(line));
    if (!(words >> word)) continue;
    if (word == "ascii") layout.encoding = Encoding::text;
    if (word == "point_data") words >> points;
    if (word == "scalars" && points > 0) {
      std::uint64_t components = 1;
      words >> name >> type >> components;
      layout.value_count = points * std::max<std::uint64_t>(components, 1);
      const auto after = file.tellg();  // a table of colours follows, or none
      if (!std::getline(file, line) || !lower_case(line).starts_with("lookup_table"))
        file.seekg(after);
    } else if (word == "field" && points > 0 && std::getline(file, line)) {
      std::uint64_t components = 0, tuples = 0;
      std::istringstream(lower_case(line)) >> name >> components >> tuples >> type;
      layout.value_count = components * tuples;
    } else {
      continue;
    }
    if (layout.value_count > kMostValues) refuse(path, "its header promises an absurd size");
    layout.value_bytes = std::uint64_t(legacy_vtk_bytes(type));
    layout.offset = std::uint64_t(file.tellg());
    layout.files = {path};
    break;
  }
  return layout;
}

/// Skips lines at the head of a file of data.
void skip_lines(std::istream& file, std::uint64_t count) {
  std::string line;
  for (std::uint64_t n = 0; n < count && std::getline(file, line); ++n) {
  }
}

/// The length of what a stream of zlib or gzip holds; nothing if it has no proper end.
std::optional<std::uint64_t> inflated_length(std::istream& file) {
  z_stream stream{};
  constexpr int kZlibOrGzip = 15 + 32;
  if (inflateInit2(&stream, kZlibOrGzip) != Z_OK) return std::nullopt;
  std::vector<unsigned char> in(kChunk), out(kChunk);
  int state = Z_OK;
  std::uint64_t length = 0;
  while (state == Z_OK && file) {
    file.read(reinterpret_cast<char*>(in.data()), std::streamsize(in.size()));
    stream.next_in = in.data();
    stream.avail_in = unsigned(file.gcount());
    while (state == Z_OK && stream.avail_in > 0) {
      stream.next_out = out.data();
      stream.avail_out = unsigned(out.size());
      state = inflate(&stream, Z_NO_FLUSH);
      length += out.size() - stream.avail_out;
    }
  }
  inflateEnd(&stream);
  return state == Z_STREAM_END ? std::optional(length) : std::nullopt;
}

/// Numbers that end in white space, or hexadecimal digits.
std::uint64_t written_count(std::istream& file, Encoding encoding) {
  std::uint64_t count = 0;
  bool in_number = false;
  std::vector<char> chunk(kChunk);
  while (file) {
    file.read(chunk.data(), std::streamsize(chunk.size()));
    for (std::streamsize n = 0; n < file.gcount(); ++n) {
      const auto c = static_cast<unsigned char>(chunk[std::size_t(n)]);
      const bool is_blank = std::isspace(c) || c == ',';
      count += encoding == Encoding::hex ? std::isxdigit(c) != 0 : is_blank && in_number;
      in_number = !is_blank;
    }
  }
  return count;
}

void check_file(const fs::path& file, const Layout& layout, VolumePart part) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  if (error) refuse(file, "its header names this file, which is not there");
  const std::uint64_t values = (layout.value_count + layout.files.size() - 1) / layout.files.size();
  const std::uint64_t bytes = values * layout.value_bytes;
  const std::string promise = std::to_string(bytes) + " bytes of voxels were promised";
  if (layout.encoding == Encoding::raw && size < layout.offset + layout.skipped + bytes)
    refuse(file, promise);
  if (part == VolumePart::header || layout.encoding == Encoding::raw) return;
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(std::streamoff(layout.offset));
  skip_lines(stream, layout.lines);
  if (layout.encoding == Encoding::deflated) {
    const auto length = inflated_length(stream);
    if (!length) refuse(file, "its compressed voxels break off");
    if (*length < layout.skipped + bytes) refuse(file, promise);
  } else if (layout.encoding != Encoding::other) {
    const std::uint64_t wanted = layout.encoding == Encoding::hex ? 2 * bytes : values;
    if (written_count(stream, layout.encoding) < wanted) refuse(file, promise);
  }
}

/// An XML file is whole if its root element is closed.
void check_closed(const fs::path& path) {
  constexpr std::streamoff kTail = 4096;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg();
  file.seekg(std::max<std::streamoff>(0, size - kTail));
  std::string tail(std::size_t(std::min(size, kTail)), '\0');
  file.read(tail.data(), std::streamsize(tail.size()));
  if (!trimmed(tail).ends_with("</VTKFile>")) refuse(path, "it does not end as it should");
}

}  // namespace

void check_complete(const fs::path& path, VolumePart part) {
  const std::string format = volume_file_format(path);
  if (format == "VTK image" && lower_extension(path) != ".vtk") return check_closed(path);
  if (format == "NIfTI" || format == "TIFF") return;  // counted where it is read
  const bool is_nrrd = format == "NRRD";
  const bool is_legacy_vtk = format == "VTK image";
  const Layout layout = is_legacy_vtk ? legacy_vtk_layout(path)
                        : is_nrrd     ? nrrd_layout(path)
                                      : meta_image_layout(path);
  if (is_legacy_vtk && layout.files.empty()) return;  // told where it is read
  if (layout.files.empty()) refuse(path, "its header names no file of voxels");
  if (layout.value_bytes == 0) return;  // refused by name where it is read
  for (const fs::path& file : layout.files) check_file(file, layout, part);
}

}  // namespace angio::segmentation::detail
