#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkMetaImageIO.h>
#include <itkMultiThreaderBase.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <new>
#include <system_error>

#include "core/error.hpp"
#include "core/text.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation::detail {
namespace {

using Image = itk::Image<float, 3>;

itk::ImageIOBase::Pointer make_io(const std::string& format) {
  if (format == "NRRD") return itk::NrrdImageIO::New().GetPointer();
  if (format == "TIFF") return itk::TIFFImageIO::New().GetPointer();
  return itk::MetaImageIO::New().GetPointer();
}

/// The text head of a NRRD or MetaImage file, in lower case, up to its end mark.
std::string header_text(const std::filesystem::path& path, const std::string& format) {
  constexpr std::size_t kMaxHeaderBytes = std::size_t(1) << 20;
  std::ifstream file(path, std::ios::binary);
  std::string text;
  for (std::string line; text.size() < kMaxHeaderBytes && std::getline(file, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() && format == "NRRD") break;
    line = lower_case(line);
    text += line + "\n";
    if (line.starts_with("elementdatafile")) break;
  }
  return text;
}

/// Voxels in a file of their own lie beside the header: a header may come from elsewhere, and ITK
/// reads whatever file it names.
///
/// @throws InputError if a data file lies elsewhere, or is no regular file
void check_data_files(const std::filesystem::path& path) {
  constexpr int kMostLines = 100000;
  std::ifstream file(path, std::ios::binary);
  const auto trimmed = [](const std::string& words) {
    const auto first = words.find_first_not_of(" \t");
    return first == std::string::npos
               ? std::string()
               : words.substr(first, words.find_last_not_of(" \t") - first + 1);
  };
  const auto check = [&](const std::string& words) {
    const std::string name = trimmed(words);
    const std::string first = name.substr(0, name.find_first_of(" \t"));
    if (name.find_first_of("/\\") != std::string::npos)
      throw InputError(
          path.filename().string() +
          " takes its voxels from another folder (a data file lies beside its header). "
          "Move it there, and name it without a folder");
    const bool is_pattern = first.find('%') != std::string::npos;
    std::error_code is_no_name;  // too long, or with bytes that no file's name has
    if (!is_pattern && !std::filesystem::is_regular_file(path.parent_path() / name, is_no_name) &&
        !std::filesystem::is_regular_file(path.parent_path() / first, is_no_name))
      throw InputError(path.filename().string() +
                       " takes its voxels from a file that is missing or no regular file. It lies "
                       "beside its header");
  };
  bool is_list = false;
  std::string line;
  for (int count = 0; count < kMostLines && std::getline(file, line); ++count) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::string lower = lower_case(line);
    if (is_list) {
      if (!trimmed(line).empty()) check(line);
      continue;
    }
    if (line.empty()) return;  // the end of a NRRD's header
    const bool is_meta = lower.starts_with("elementdatafile");
    if (!is_meta && !lower.starts_with("data file:") && !lower.starts_with("datafile:")) continue;
    const std::string value = trimmed(line.substr(line.find(is_meta ? '=' : ':') + 1));
    if (lower_case(value) == "local") return;
    is_list = lower_case(value).starts_with("list");
    if (!is_list) return check(value);
  }
}

/// MetaIO reads as many numbers as a file says that it has dimensions, and of -3 never comes back.
void check_dimensions(const std::string& header, const std::string& name) {
  constexpr int kMost = 10;
  const std::string text = "\n" + header, field = "\nndims";
  for (std::size_t at = text.find(field); at != std::string::npos; at = text.find(field, at + 1)) {
    const std::size_t value = text.find_first_not_of(" \t=", at + field.size());
    const int count = value == std::string::npos ? 0 : std::atoi(text.c_str() + value);
    if (count < 1 || count > kMost)
      throw InputError(name + " has " + std::to_string(count) +
                       " dimensions, as its NDims says (its header is damaged). Export it again");
  }
}

/// ITK takes a missing spacing for 1 mm and any unit for mm; both are refused here.
///
/// @return whether it states a spacing; if not, the user has to
bool check_header_text(const std::filesystem::path& path, const std::string& format,
                       const ReadOptions& options, std::vector<std::string>& warnings) {
  const std::string text = header_text(path, format);
  const std::string name = path.filename().string();
  const bool nrrd = format == "NRRD";
  if (nrrd ? !text.starts_with("nrrd") : text.find("ndims") == std::string::npos)
    throw InputError(name + " is no " + format + " file (" +
                     (nrrd ? "it does not begin with NRRD" : "its header states no NDims") +
                     "). Check what it is, or export the volume again");
  const bool has_spacing = nrrd ? text.find("\nspace directions:") != std::string::npos ||
                                      text.find("\nspacings:") != std::string::npos
                                : text.find("elementspacing") != std::string::npos ||
                                      text.find("elementsize") != std::string::npos;
  if (!has_spacing && options.spacing_mm[0] <= 0.0)
    throw InputError(name + " states no voxel spacing (no length can be measured). Add " +
                     (nrrd ? "\"space directions\"" : "\"ElementSpacing\"") +
                     " to its header, or give --spacing");
  if (!nrrd) {
    check_dimensions(text, name);
    return has_spacing;
  }
  const auto units = text.find("\nspace units:");
  if (units != std::string::npos) {
    const std::string line = text.substr(units + 1, text.find('\n', units + 1) - units - 1);
    if (line.find("\"mm\"") == std::string::npos && line.find("millimet") == std::string::npos &&
        line.find("\"\"") == std::string::npos)
      throw InputError(name + " is not in mm (" + line + "). Convert it to mm");
  }
  const auto has = [&](const char* field) { return text.find(field) != std::string::npos; };
  if (has("\nspace directions:") && !has("\nspace:") && !has("\nspace dimension:"))
    throw InputError(name +
                     " has \"space directions\" but names no space (the format asks for one). Add "
                     "a line \"space dimension: 3\" to its header, before them");
  if (!has("\nspace:"))
    warnings.push_back(std::string("the file names ") + kNoPatientSpace +
                       "; its axes were taken as LPS");
  return has_spacing;
}

void check_image_information(const itk::ImageIOBase& io, const std::string& name) {
  if (io.GetNumberOfComponents() != 1)
    throw InputError(name + " has " + std::to_string(io.GetNumberOfComponents()) +
                     " values per voxel (colours or vectors, not intensities). Give a volume with "
                     "one");
  if (io.GetNumberOfDimensions() < 3)
    throw InputError(name + " is not three-dimensional. Give a volume");
  for (unsigned int axis = 3; axis < io.GetNumberOfDimensions(); ++axis)
    if (io.GetDimensions(axis) > 1)
      throw InputError(name + " has several time points (one volume is needed). Give one of them");
}

/// A TIFF file states the size of a print's dots at most, so that its spacing must be given.
void require_given_spacing(const std::string& name, const ReadOptions& options) {
  if (options.spacing_mm[0] <= 0.0)
    throw InputError(name +
                     " states no voxel spacing (no TIFF file does, and no length can be measured). "
                     "Give --spacing X,Y,Z in mm");
}

VolumeGeometry geometry_of(const itk::ImageIOBase& io) {
  VolumeGeometry geometry;
  for (unsigned int axis = 0; axis < 3; ++axis) {
    geometry.size[axis] = int(std::min<itk::SizeValueType>(io.GetDimensions(axis), 1u << 20));
    geometry.spacing[int(axis)] = io.GetSpacing(axis);
    geometry.origin[int(axis)] = io.GetOrigin(axis);
    const auto direction = io.GetDirection(axis);
    for (unsigned int row = 0; row < 3; ++row)
      geometry.direction(int(row), int(axis)) = direction[row];
  }
  return geometry;
}

void take_given_spacing(const ReadOptions& options, VolumeFile& file) {
  for (int axis = 0; axis < 3; ++axis)
    file.volume.geometry.spacing[axis] = options.spacing_mm[std::size_t(axis)];
  file.warnings.push_back(
      "the file states no voxel size; the one you gave was taken, and every length rests on that");
}

[[noreturn]] void fail(const std::string& name, const std::string& format) {
  throw InputError("cannot read " + name + " (truncated, damaged, or not a " + format +
                   " file). Copy or export it again");
}

}  // namespace

VolumeFile load_with_itk(const std::filesystem::path& path, VolumePart part,
                         const ReadOptions& options) {
  const std::string name = path.filename().string();
  const std::string format = volume_file_format(path);
  VolumeFile file;
  bool has_spacing = false;
  if (format == "TIFF") {
    require_given_spacing(name, options);
    file.warnings.push_back(std::string("the file names ") + kNoPatientSpace +
                            "; its axes were taken as LPS");
  } else {
    has_spacing = check_header_text(path, format, options, file.warnings);
    check_data_files(path);
  }
  // A thread per core would take more address space than the child may have; none is of use here.
  itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(1);
  itk::ImageIOBase::Pointer io = make_io(format);
  try {
    if (!io->CanReadFile(path.c_str())) fail(name, format);
    io->SetFileName(path.string());
    io->ReadImageInformation();
    check_image_information(*io, name);
    file.volume.geometry = geometry_of(*io);
    if (!has_spacing) take_given_spacing(options, file);
    if (part == VolumePart::header) return file;

    auto reader = itk::ImageFileReader<Image>::New();
    reader->SetImageIO(io);
    reader->SetFileName(path.string());
    reader->Update();
    const Image& image = *reader->GetOutput();
    const std::size_t count = image.GetBufferedRegion().GetNumberOfPixels();
    if (count != file.volume.geometry.voxel_count()) fail(name, format);
    file.volume.values.assign(image.GetBufferPointer(), image.GetBufferPointer() + count);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {  // ITK's own, and of lengths that MetaIO believes
    fail(name, format);
  }
  return file;
}

}  // namespace angio::segmentation::detail
