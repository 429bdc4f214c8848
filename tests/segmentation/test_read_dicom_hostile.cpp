#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zip.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <random>

#include "core/atomic_file.hpp"
#include "formats/nrrd.hpp"
#include "tests/segmentation/dicom_objects.hpp"

/// Files that are damaged, or made to do damage.
namespace angio::segmentation {
namespace {
using testing::HasSubstr;

using HostileDicom = DicomFolder;

TEST_F(HostileDicom, SizesThatOverflow32BitsAreRefused) {
  Slice slice;
  slice.more = [](DcmDataset& d) {
    d.putAndInsertUint16(DCM_Rows, 65535);
    d.putAndInsertUint16(DCM_Columns, 65535);
    put(d, DCM_NumberOfFrames, "65535");
  };
  write_series(2, slice);
  EXPECT_THAT(refusal(), HasSubstr("truncated"));
  slice.more = [](DcmDataset& d) { put(d, DCM_NumberOfFrames, "2147483647"); };
  write_series(2, slice);
  EXPECT_THAT(refusal(), HasSubstr("number of frames is impossible"));
}

TEST_F(HostileDicom, SequencesNestedWithoutEndDoNotTakeTheProgramDown) {
  write_series(3);
  std::string bytes = read_text(file("a100"));
  // (0040,0275) SQ of undefined length with an item of undefined length, again and again.
  std::string nested;
  for (int level = 0; level < 200000; ++level)
    nested.append("\x40\x00\x75\x02SQ\x00\x00\xff\xff\xff\xff\xfe\xff\x00\xe0\xff\xff\xff\xff", 20);
  const std::string pixels("\xe0\x7f\x10\x00", 4);
  bytes.insert(bytes.rfind(pixels), nested);
  std::ofstream(file("b"), std::ios::binary) << bytes;
  const auto loaded = read_volume(folder(), {});
  EXPECT_EQ(loaded.volume.geometry.size[2], 3);
  EXPECT_THAT(loaded.warnings, testing::ElementsAre(HasSubstr("a file of no known series")));
}

/// Truncated, or a few bytes changed, more often where headers are.
std::string mutate(const std::string& whole, std::mt19937& random) {
  std::string bytes = whole;
  if (random() % 4 == 0) {
    bytes.resize(random() % whole.size());
    return bytes;
  }
  const int count = 1 + int(random() % 8);
  for (int b = 0; b < count; ++b) {
    const std::size_t range =
        random() % 3 == 0 ? whole.size() : std::min<std::size_t>(whole.size(), 1500);
    const std::size_t place = random() % range;
    const unsigned char kinds[] = {0x00, 0xff, 0x7f, 0x80, static_cast<unsigned char>(random())};
    bytes[place] = char(kinds[random() % 5]);
  }
  return bytes;
}

struct FuzzCount {
  int read = 0;
  int refused = 0;
};

/// Reads and inspects mutations of a file; anything but success or a proper error fails the test.
FuzzCount fuzz(const fs::path& seed, const fs::path& folder, int trial_count, unsigned number) {
  FuzzCount count;
  const std::string whole = read_text(seed);
  std::mt19937 random(number);
  for (int trial = 0; trial < trial_count; ++trial) {
    const fs::path victim = folder / ("victim" + seed.extension().string());
    std::ofstream(victim, std::ios::binary) << mutate(whole, random);
    try {
      inspect(folder);
      const auto loaded = read_volume(folder, {.allow_lossy = true, .resample = true});
      EXPECT_EQ(loaded.volume.values.size(), loaded.volume.geometry.voxel_count());
      ++count.read;
    } catch (const InputError&) {
      ++count.refused;
    }
  }
  return count;
}

/// Small objects of every kind that is read.
std::vector<fs::path> make_seeds(const fs::path& folder) {
  fs::create_directories(folder);
  Slice slice;
  slice.position.z = 9.0;
  write_slice(folder / "ct", slice);
  write_slice(folder / "implicit", slice, EXS_LittleEndianImplicit);
  write_slice(folder / "big", slice, EXS_BigEndianExplicit);
  write_slice(folder / "deflated", slice, EXS_DeflatedLittleEndianExplicit);
  for (const char* sop_class : {UID_XRay3DAngiographicImageStorage, UID_EnhancedXAImageStorage}) {
    EnhancedObject object;
    for (int k = 0; k < 3; ++k) {
      slice.sop_class = sop_class;
      slice.position.z = 0.3 * k;
      object.frames.push_back(slice);
    }
    write_enhanced(folder / (sop_class == std::string(UID_EnhancedXAImageStorage) ? "xa" : "x3"),
                   object);
  }
  std::vector<fs::path> seeds;
  for (const auto& entry : fs::directory_iterator(folder)) seeds.push_back(entry.path());
  std::sort(seeds.begin(), seeds.end());
  return seeds;
}

/// Mutations per seed: ANGIO_FUZZ in the environment, or enough for a minute's test.
int trials_per_seed() {
  const char* wanted = std::getenv("ANGIO_FUZZ");
  return wanted ? std::atoi(wanted) : 60;
}

TEST_F(HostileDicom, MutatedFilesAreReadOrRefused) {
  const auto seeds = make_seeds(file("seeds"));
  fs::create_directories(file("in"));
  Slice neighbour;  // with it, a single slice makes a volume
  neighbour.position.z = 8.5;
  write_slice(file("in/whole"), neighbour);
  FuzzCount total;
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    const FuzzCount count = fuzz(seeds[s], file("in"), trials_per_seed(), unsigned(s));
    total.read += count.read;
    total.refused += count.refused;
  }
  std::cout << total.read << " mutated files read, " << total.refused << " refused\n";
  EXPECT_EQ(total.read + total.refused, trials_per_seed() * int(seeds.size()));
}

TEST_F(HostileDicom, MutatedCompressedFilesAreReadOrRefused) {
  const char* data = std::getenv("ANGIO_DATA");
  if (!data) GTEST_SKIP() << "ANGIO_DATA is not set";
  fs::create_directories(file("in"));
  FuzzCount total;
  int seed_count = 0;
  for (const char* name : {"dicom-codecs/XA1_RLE", "dicom-codecs/XA1_JPLL", "dicom-codecs/XA1_JLSL",
                           "dicom-codecs/XA1_J2KR", "dicom-traps/x3_ok.dcm"}) {
    // As X-ray projections these are refused before their pixels are touched; as CT they are not.
    DcmFileFormat object;
    ASSERT_TRUE(object.loadFile((fs::path(data) / name).c_str()).good());
    object.loadAllDataIntoMemory();
    put(*object.getDataset(), DCM_SOPClassUID, UID_CTImageStorage);
    put(*object.getDataset(), DCM_ImageOrientationPatient, "1\\0\\0\\0\\1\\0");
    put(*object.getDataset(), DCM_ImagePositionPatient, "0\\0\\1");
    put(*object.getDataset(), DCM_PixelSpacing, "1\\1");
    const E_TransferSyntax syntax = object.getDataset()->getOriginalXfer();
    ASSERT_TRUE(object.saveFile(file("seed").c_str(), syntax).good());
    put(*object.getDataset(), DCM_ImagePositionPatient, "0\\0\\2");
    put(*object.getDataset(), DCM_SOPInstanceUID, "1.2.3");
    ASSERT_TRUE(object.saveFile(file("in/whole").c_str(), syntax).good());
    const FuzzCount count =
        fuzz(file("seed"), file("in"), std::max(4, trials_per_seed() / 10), unsigned(++seed_count));
    total.read += count.read;
    total.refused += count.refused;
  }
  std::cout << total.read << " mutated files read, " << total.refused << " refused\n";
}

TEST_F(HostileDicom, MutatedArchivesAndDirectoriesAreReadOrRefused) {
  fs::create_directories(file("in"));
  write_series(3, {}, EXS_LittleEndianExplicit, "in/s");
  int error = 0;
  zip_t* zip = zip_open(file("seed.zip").c_str(), ZIP_CREATE, &error);
  ASSERT_TRUE(zip);
  DcmFileFormat dicomdir;
  put(*dicomdir.getDataset(), DCM_SOPClassUID, UID_MediaStorageDirectoryStorage);
  put(*dicomdir.getDataset(), DCM_SOPInstanceUID, "1.2.3");
  for (const char* name : {"s100", "s99", "s98"}) {
    zip_source_t* source = zip_source_file(zip, file(std::string("in/") + name).c_str(), 0, -1);
    ASSERT_GE(zip_file_add(zip, name, source, 0), 0);
    DcmItem* record = nullptr;
    ASSERT_TRUE(dicomdir.getDataset()
                    ->findOrCreateSequenceItem(DCM_DirectoryRecordSequence, record, -2)
                    .good());
    put(*record, DCM_DirectoryRecordType, "IMAGE");
    std::string id = std::string("S") + (name + 1);
    put(*record, DCM_ReferencedFileID, id);
  }
  ASSERT_EQ(zip_close(zip), 0);
  ASSERT_TRUE(dicomdir.saveFile(file("DICOMDIR").c_str(), EXS_LittleEndianExplicit).good());
  FuzzCount total;
  for (const auto& [seed, victim] :
       {std::pair{"seed.zip", "victim.zip"}, std::pair{"DICOMDIR", "in/DICOMDIR"}}) {
    const std::string whole = read_text(file(seed));
    std::mt19937 random(5);
    for (int trial = 0; trial < trials_per_seed(); ++trial) {
      std::ofstream(file(victim), std::ios::binary) << mutate(whole, random);
      try {
        read_volume(file(victim), {});
        ++total.read;
      } catch (const InputError&) {
        ++total.refused;
      }
    }
  }
  std::cout << total.read << " mutated files read, " << total.refused << " refused\n";
}

TEST_F(HostileDicom, MutatedVolumeFilesAreReadOrRefused) {
  VolumeGeometry geometry;
  geometry.size = {6, 5, 4};
  Volume<float> volume(geometry);
  for (std::size_t v = 0; v < volume.values.size(); ++v) volume.values[v] = float(v);
  formats::write_nrrd(file("seed.nrrd"), volume);
  std::ofstream(file("seed.mha"), std::ios::binary)
      << "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
         "ElementSpacing = 1 1 1\nElementDataFile = LOCAL\n01234567";
  std::ofstream(file("seed.vti"))
      << "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">"
         "<ImageData WholeExtent=\"0 1 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\">"
         "<Piece Extent=\"0 1 0 1 0 1\"><PointData Scalars=\"a\"><DataArray type=\"Float32\" "
         "Name=\"a\" format=\"ascii\">0 1 2 3 4 5 6 7</DataArray></PointData></Piece></ImageData>"
         "</VTKFile>";
  FuzzCount total;
  for (const char* name : {"seed.nrrd", "seed.mha", "seed.vti"}) {
    const std::string whole = read_text(file(name));
    std::mt19937 random(3);
    for (int trial = 0; trial < trials_per_seed(); ++trial) {
      const fs::path victim = file("victim" + fs::path(name).extension().string());
      std::ofstream(victim, std::ios::binary) << mutate(whole, random);
      try {
        inspect(victim);
        read_volume(victim, {});
        ++total.read;
      } catch (const InputError&) {
        ++total.refused;
      }
    }
  }
  std::cout << total.read << " mutated files read, " << total.refused << " refused\n";
}

}  // namespace
}  // namespace angio::segmentation
