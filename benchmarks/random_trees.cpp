// random_trees [lines|aneurysms|two-inlets|level-set] [FIRST_SEED] [COUNT] [each]: the stenoses
// that are listed on random vessel trees against those that are there, beside a plain rule.
// `lines`: radii along the true lines, with noise; `aneurysms`: the same with one or two large
// aneurysms a tree; `two-inlets`: two trees joined by an end of each, as communicating arteries do;
// `level-set`: lines extracted from smaller trees. `each` prints what went wrong.
//
// There: a stretch narrowed by at least 20 %, whose severity is that of its tightest place. Found:
// a listed stenosis (30 % or more) overlaps it. False: a listed stenosis without a narrowing of 20
// % within it or a diameter beside its tightest place.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "core/parallel.hpp"
#include "testing/centerline/tree_lines.hpp"
#include "testing/result_table.hpp"

namespace angio::benchmarks {
namespace {

constexpr double kListed = 30.0;  // percent: what find_lesions lists

// ---- rules ----------------------------------------------------------------------------------

struct Listed {
  int path = 0;
  double abscissa = 0.0, proximal = 0.0, distal = 0.0, percent = 0.0;
};

std::vector<Listed> list_ours(const CenterlineTree& tree) {
  std::vector<Listed> listed;
  for (const centerline::Lesion& lesion : centerline::find_lesions(tree, {}))
    if (lesion.is_stenosis)
      listed.push_back({lesion.path_id, lesion.abscissa_mm, lesion.proximal_mm, lesion.distal_mm,
                        lesion.diameter_stenosis_percent});
  return listed;
}

/// The plain rule: a diameter against the mean of those two diameters before and behind, or of the
/// one that there is.
std::vector<Listed> list_plainly(const CenterlineTree& tree) {
  std::vector<Listed> listed;
  std::vector<Vec3> known;
  for (const CenterlinePath& path : tree.paths) {
    const double length = path.abscissa.back();
    std::vector<double> percent(path.points.size(), 0.0);
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      double wide = path.inscribed_radius[i];
      for (std::size_t k = 0; k < path.points.size(); ++k)
        if (std::abs(path.abscissa[k] - path.abscissa[i]) < 2.0 * path.inscribed_radius[k])
          wide = std::max(wide, path.inscribed_radius[k]);
      double sum = 0.0;
      int sides = 0;
      for (const double s : {path.abscissa[i] - 4.0 * wide, path.abscissa[i] + 4.0 * wide})
        if (s >= 0.0 && s <= length) {
          sum += sample(path, s).inscribed_radius;
          ++sides;
        }
      if (sides > 0) percent[i] = 100.0 * (1.0 - path.inscribed_radius[i] * sides / sum);
    }
    for (std::size_t i = 0; i < percent.size(); ++i) {
      if (percent[i] < kNarrow) continue;
      const std::size_t first = i;
      std::size_t worst = i;
      for (; i < percent.size() && percent[i] >= kNarrow; ++i)
        if (percent[i] > percent[worst]) worst = i;
      if (percent[worst] < kListed) continue;
      const Vec3 at = path.points[worst];
      if (std::any_of(known.begin(), known.end(), [&](const Vec3& other) {
            return distance(other, at) < path.inscribed_radius[worst];
          }))
        continue;
      known.push_back(at);
      listed.push_back({path.id, path.abscissa[worst], path.abscissa[first], path.abscissa[i - 1],
                        percent[worst]});
    }
  }
  return listed;
}

// ---- scores ---------------------------------------------------------------------------------

constexpr int kBands = 5;
constexpr double kBandFrom[kBands + 1] = {20.0, 30.0, 50.0, 70.0, 90.0, 100.0};

struct Band {
  int there = 0, found = 0;
  std::vector<double> errors;  ///< of the percent stenosis, in points

  void add(const Band& other) {
    there += other.there;
    found += other.found;
    errors.insert(errors.end(), other.errors.begin(), other.errors.end());
  }
};

struct Score {
  int trees = 0, false_ones = 0, false_of_50 = 0;
  std::array<Band, kBands> bands;
  Band middle;  ///< 50 to 90 %
  Band whole;   ///< of these, what leaves less than a diameter of its branch healthy
  Band hidden;  ///< 50 % or more, tightest inside a branching, where nothing is measured

  void add(const Score& other) {
    trees += other.trees;
    false_ones += other.false_ones;
    false_of_50 += other.false_of_50;
    for (int k = 0; k < kBands; ++k) bands[std::size_t(k)].add(other.bands[std::size_t(k)]);
    middle.add(other.middle);
    whole.add(other.whole);
    hidden.add(other.hidden);
  }
};

int band_of(double percent) {
  int band = 0;
  while (band + 1 < kBands && percent >= kBandFrom[band + 1]) ++band;
  return band;
}

/// Places of a path's points from an abscissa to another.
std::vector<Place> places_between(const Lines& lines, int path, double first, double last) {
  std::vector<Place> places;
  const auto& abscissa = lines.tree.paths[std::size_t(path)].abscissa;
  for (std::size_t i = 0; i < abscissa.size(); ++i)
    if (abscissa[i] >= first && abscissa[i] <= last)
      places.push_back(lines.places[std::size_t(path)][i]);
  return places;
}

/// The deepest of the true lesions that a listed one overlaps; all of them are found.
TrueLesion* match(const Lines& lines, const Listed& entry, std::vector<TrueLesion>& lesions) {
  const auto touched = places_between(lines, entry.path, entry.proximal, entry.distal);
  TrueLesion* deepest = nullptr;
  for (TrueLesion& lesion : lesions) {
    const bool overlaps = std::any_of(touched.begin(), touched.end(), [&](const Place& place) {
      return place.branch == lesion.branch && place.sample >= lesion.first &&
             place.sample <= lesion.last;
    });
    if (!overlaps) continue;
    lesion.found = true;
    if (!deepest || lesion.percent > deepest->percent) deepest = &lesion;
  }
  return deepest;
}

bool is_false(const TrueTree& truth, const Lines& lines, const Listed& entry) {
  const Place at =
      find_place(truth, sample(lines.tree.paths[std::size_t(entry.path)], entry.abscissa).point);
  const double diameter =
      2.0 * truth.branches[std::size_t(at.branch)].healthy[std::size_t(at.sample)];
  const auto near =
      places_between(lines, entry.path, entry.abscissa - diameter, entry.abscissa + diameter);
  return std::none_of(near.begin(), near.end(), [&](const Place& place) {
    return true_percent(truth.branches[std::size_t(place.branch)], place.sample) >= kNarrow;
  });
}

enum class Output { table, each };

Score compare(const TrueTree& truth, const Lines& lines, const std::vector<Listed>& listed,
              Output output, unsigned seed) {
  Score score;
  score.trees = 1;
  auto lesions = find_true_lesions(truth, find_measured(truth, lines));
  const auto is_middle = [](double percent) { return percent >= 50.0 && percent < 90.0; };
  for (const Listed& entry : listed) {
    const TrueLesion* lesion = match(lines, entry, lesions);
    if (!lesion && is_false(truth, lines, entry)) {
      ++score.false_ones;
      score.false_of_50 += entry.percent >= 50.0;
      if (output == Output::each)
        std::printf("seed %u: false, %.0f %% on path %d at %.1f mm\n", seed, entry.percent,
                    entry.path, entry.abscissa);
    }
    if (!lesion || !lesion->measured) continue;
    const double error = entry.percent - lesion->percent;
    score.bands[std::size_t(band_of(lesion->percent))].errors.push_back(error);
    if (is_middle(lesion->percent)) score.middle.errors.push_back(error);
    if (output == Output::each && std::abs(error) > 6.0)
      std::printf("seed %u: %.0f %% read as %.0f %%, path %d at %.1f mm\n", seed, lesion->percent,
                  entry.percent, entry.path, entry.abscissa);
  }
  for (const TrueLesion& lesion : lesions) {
    const auto count = [&](Band& band) {
      ++band.there;
      band.found += lesion.found;
    };
    if (!lesion.measured) {
      if (lesion.percent >= 50.0) count(score.hidden);
      continue;
    }
    count(score.bands[std::size_t(band_of(lesion.percent))]);
    if (is_middle(lesion.percent)) count(score.middle);
    if (is_middle(lesion.percent) && lesion.is_whole) count(score.whole);
    if (output == Output::each && !lesion.found && lesion.percent >= kListed)
      std::printf("seed %u: missed, %.0f %% on branch %d%s\n", seed, lesion.percent, lesion.branch,
                  lesion.is_whole ? ", all of it" : "");
  }
  return score;
}

void print(const std::string& name, const Band& band, ResultTable& results) {
  double sum = 0.0, squares = 0.0, absolute = 0.0;
  std::vector<double> magnitudes;
  for (const double e : band.errors) {
    sum += e;
    squares += e * e;
    absolute += std::abs(e);
    magnitudes.push_back(std::abs(e));
  }
  std::sort(magnitudes.begin(), magnitudes.end());
  const double n = std::max<double>(1.0, double(magnitudes.size()));
  const double worst =
      magnitudes.empty() ? 0.0 : magnitudes[std::size_t(0.95 * double(magnitudes.size() - 1))];
  results.row({name, std::to_string(band.there),
               formatted("%.1f", 100.0 * band.found / std::max(1, band.there)),
               formatted("%+.1f", sum / n),
               formatted("%.1f", std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n)))),
               formatted("%.1f", absolute / n), formatted("%.1f", worst)});
}

void print(const char* name, const Score& score, ResultTable& results) {
  results.section(name);
  results.paragraph(formatted(
      "%d trees, %d false (%.3f a tree; %d of them read as 50 %% or more).", score.trees,
      score.false_ones, double(score.false_ones) / std::max(1, score.trees), score.false_of_50));
  results.columns(
      {"true stenosis", "there", "found %", "%DS bias", "sd", "mean error", "95 % of errors"});
  for (int k = 0; k < kBands; ++k)
    print(std::to_string(int(kBandFrom[k])) + " to " + std::to_string(int(kBandFrom[k + 1])) + " %",
          score.bands[std::size_t(k)], results);
  print("**50 to 90 %**", score.middle, results);
  results.paragraph(
      formatted("50 to 90 %%, of a whole branch: %d of %d found; the others: %d of %d (%.1f %%).\n"
                "50 %% or more, tightest inside a branching: %d of %d found.",
                score.whole.found, score.whole.there, score.middle.found - score.whole.found,
                score.middle.there - score.whole.there,
                100.0 * (score.middle.found - score.whole.found) /
                    std::max(1, score.middle.there - score.whole.there),
                score.hidden.found, score.hidden.there));
}

enum class Source { lines, aneurysms, two_inlets, level_set };

GrowOptions grow_options(Source source) {
  if (source == Source::level_set) return {.most_branches = 6, .most_diameters = 8.0};
  return {.with_aneurysms = source == Source::aneurysms,
          .with_two_inlets = source == Source::two_inlets};
}

void run(Source source, unsigned first, int count, Output output, ResultTable& results) {
  const auto size = std::size_t(count);
  std::vector<Score> ours(size), plain(size);
  parallel_for_uneven(count, [&](std::ptrdiff_t i) {
    const unsigned seed = first + unsigned(i);
    const TrueTree truth = draw_tree(seed, grow_options(source));
    const auto lines =
        source == Source::level_set ? extract_lines(truth, seed) : make_lines(truth, seed);
    if (!lines) return;
    ours[std::size_t(i)] = compare(truth, *lines, list_ours(lines->tree), output, seed);
    plain[std::size_t(i)] = compare(truth, *lines, list_plainly(lines->tree), Output::table, seed);
  });
  Score all, all_plain;
  for (const Score& score : ours) all.add(score);
  for (const Score& score : plain) all_plain.add(score);
  print("This program", all, results);
  print("Plain rule", all_plain, results);
}

}  // namespace
}  // namespace angio::benchmarks

int main(int argument_count, char** arguments) {
  using namespace angio::benchmarks;
  try {
    ResultTable results("Stenoses found on random trees", argument_count, arguments);
    const auto is = [&](int k, const char* word) {
      return argument_count > k && std::strcmp(arguments[k], word) == 0;
    };
    const unsigned first = argument_count > 2 ? unsigned(std::atoi(arguments[2])) : 0;
    const int count = argument_count > 3 ? std::max(1, std::atoi(arguments[3])) : 300;
    const Source source = is(1, "level-set")    ? Source::level_set
                          : is(1, "aneurysms")  ? Source::aneurysms
                          : is(1, "two-inlets") ? Source::two_inlets
                                                : Source::lines;
    run(source, first, count, is(4, "each") ? Output::each : Output::table, results);
    results.write();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "random_trees: %s\n", error.what());
    return 1;
  }
}
