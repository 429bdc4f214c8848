#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"

namespace angio::datasets {

inline constexpr double kLumenIntensity = 400.0;      ///< CT-like, like the background
inline constexpr double kBackgroundIntensity = 40.0;  ///< [HU]

/// straight: healthy tube; concentric, unilateral, bilateral: a stenosis from all sides, one or
/// two; tandem: two stenoses in a row; helix, torus: curved tubes with a stenosis; ytype,
/// trifurcation: two or three daughters, one stenosed; aneurysm: a sac beside a tube with a
/// stenosis; coronary: left coronary tree with taper, curvature, two bifurcations and one eccentric
/// stenosis; cloth: the paper's sheet, a surface only.
struct PhantomOptions {
  std::string name = "coronary";
  double stenosis_percent = 60.0;  ///< diameter stenosis, [0, 95]; 0 is a healthy vessel
  double radius_mm = 0.0;          ///< at the inlet, [0.4, 15]; 0: the phantom's own (see README)
  double length_mm = 0.0;          ///< of the main branch, [5, 200]; 0: the phantom's own
  double spacing_mm = 0.3;         ///< of voxels, [0.05, 2]
  double slice_mm = 0.0;           ///< their length along k, [0.05, 5]; 0: spacing_mm
  double noise_sd = 0.1;           ///< fraction of the contrast, [0, 1]; 0.1 is 10 %
  double blur_mm = 0.0;  ///< sd of the scanner's blur, [0, 3]; 0: 0.6 voxels along each axis
  double oblique_degrees = 0.0;  ///< the voxel grid is turned by this around (1, 2, 3), [0, 90]
  std::uint64_t seed = 1;

  void validate() const;  ///< @throws OptionError naming the field
};

/// A stenosis, or the narrowest place of a healthy vessel.
struct LesionTruth {
  double mld_mm = 0.0;   ///< minimal lumen diameter (largest inscribed circle)
  double mla_mm2 = 0.0;  ///< minimal lumen area
  double reference_diameter_mm = 0.0;
  double diameter_stenosis_percent = 0.0;
  Vec3 lesion_point;                ///< LPS [mm]
  double lesion_abscissa_mm = 0.0;  ///< on tree.paths[lesion_path]
  int lesion_path = 0;
};

/// What is known exactly about a phantom; written as truth.json. As a LesionTruth it describes the
/// most severe stenosis.
struct PhantomTruth : LesionTruth {
  CenterlineTree tree;  ///< exact centre points and radii, inlet to each outlet
  bool has_lesion = false;
  std::vector<LesionTruth> lesions;  ///< all stenoses, the most severe first; empty in health
};

struct Phantom {
  Volume<float> volume;  ///< CT-like intensities: lumen 400, background 40
  TriangleMesh surface;  ///< closed lumen surface, LPS [mm]
  PhantomTruth truth;
};

/// Reads "NAME[,key=value...]", with or without "phantom:" before it; the keys are stenosis,
/// radius, length, spacing, slice, noise, blur, oblique and seed. @throws OptionError with the
/// nearest name that there is
PhantomOptions parse_phantom(std::string_view description);

/// Makes the surface and the truth only (the volume stays empty).
Phantom make_phantom_surface(const PhantomOptions& options);

/// The wall of a phantom in the seed paper's own mesh (its Table 2), open at the ends: unilateral
/// and bilateral 61 rings of 20 vertices (2400 triangles, 1220 vertices), ytype three tubes of 40
/// vertices a ring and 220 rows (17600, 8859). @throws OptionError for other phantoms
TriangleMesh make_paper_surface(const PhantomOptions& options);

/// Makes the volume and the truth only (the surface stays empty).
Phantom make_phantom_scan(const PhantomOptions& options, const Progress& progress = {});

/// Makes the whole phantom: exact partial volume, blur, noise.
Phantom make_phantom(const PhantomOptions& options, const Progress& progress = {});

/// dicom: a series of CT Image Storage; xray_3d: one X-Ray 3D Angiographic Image Storage object.
enum class PhantomFormat { dicom, xray_3d, nrrd, surface };

/// Writes the phantom and its truth.json into `folder`: dicom/IM0001.dcm..., volume.nrrd, or
/// lumen.stl. @return the path that `angio run` takes as its input.
std::filesystem::path write_phantom(const Phantom& phantom, const PhantomOptions& options,
                                    PhantomFormat format, const std::filesystem::path& folder);

}  // namespace angio::datasets
