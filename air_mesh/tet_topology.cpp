#include "air_mesh/tet_topology.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace angio::air_mesh {
namespace {

Triangle sorted(Triangle t) {
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  if (t[1] > t[2]) std::swap(t[1], t[2]);
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  return t;
}

}  // namespace

TetTopology::TetTopology(const std::vector<Tet>& tets)
    : tets_(tets), links_(tets.size(), {-1, -1, -1, -1}), mark_(tets.size(), 0) {
  struct Side {
    Triangle key;
    int link;
  };
  std::vector<Side> sides;
  sides.reserve(4 * tets.size());
  for (int t = 0; t < slot_count(); ++t)
    for (int c = 0; c < 4; ++c) sides.push_back({sorted(face(t, c)), 4 * t + c});
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.key != b.key ? a.key < b.key : a.link < b.link;
  });
  const auto link = [&](int from, int to) {
    links_[std::size_t(from / 4)][std::size_t(from % 4)] = to;
  };
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].key != sides[i + 1].key) continue;
    if (i + 2 < sides.size() && sides[i + 2].key == sides[i].key)
      throw InputError(
          "three tetrahedra of the air mesh share a face (it overlaps itself). Run the stage "
          "meshing again");
    link(sides[i].link, sides[i + 1].link);
    link(sides[i + 1].link, sides[i].link);
  }
}

std::vector<Tet> TetTopology::tets() const {
  std::vector<Tet> result;
  result.reserve(std::size_t(tet_count()));
  for (const Tet& t : tets_)
    if (t[0] >= 0) result.push_back(t);
  return result;
}

std::vector<TetFace> TetTopology::boundary() const {
  std::vector<TetFace> faces;
  for (int t = 0; t < slot_count(); ++t)
    for (int c = 0; alive(t) && c < 4; ++c)
      if (across(t, c).tet < 0) faces.push_back({t, c});
  return faces;
}

// Every face must be there twice: from outside and inside, or from two fresh tets.
bool TetTopology::pair_up(std::vector<FaceEntry>& entries) const {
  if (entries.size() % 2 != 0) return false;
  std::sort(entries.begin(), entries.end(), [](const FaceEntry& a, const FaceEntry& b) {
    return a.key != b.key ? a.key < b.key : a.link > b.link;
  });
  for (std::size_t i = 0; i < entries.size(); i += 2) {
    if (entries[i].key != entries[i + 1].key || entries[i + 1].link >= -1) return false;
    if (i > 0 && entries[i].key == entries[i - 1].key) return false;
  }
  return true;
}

int TetTopology::take_slot() {
  if (!free_.empty()) {
    const int slot = free_.back();
    free_.pop_back();
    return slot;
  }
  tets_.push_back({-1, -1, -1, -1});
  links_.push_back({-1, -1, -1, -1});
  mark_.push_back(0);
  return slot_count() - 1;
}

bool TetTopology::replace(const int* old, int old_count, const Tet* fresh, int fresh_count,
                          int* slots) {
  ++stamp_;
  for (int i = 0; i < old_count; ++i) mark_[std::size_t(old[i])] = stamp_;
  entries_.clear();
  for (int i = 0; i < old_count; ++i)
    for (int c = 0; c < 4; ++c) {
      const int link = links_[std::size_t(old[i])][std::size_t(c)];
      if (link >= 0 && mark_[std::size_t(link / 4)] == stamp_) continue;
      entries_.push_back({sorted(face(old[i], c)), link});
    }
  for (int i = 0; i < fresh_count; ++i)
    for (int c = 0; c < 4; ++c) {
      const Triangle& f = kTetFace[std::size_t(c)];
      const Tet& t = fresh[i];
      entries_.push_back(
          {sorted({t[std::size_t(f[0])], t[std::size_t(f[1])], t[std::size_t(f[2])]}),
           -2 - (4 * i + c)});
    }
  if (!pair_up(entries_)) return false;

  for (int i = old_count - 1; i >= 0; --i) {
    tets_[std::size_t(old[i])][0] = -1;
    free_.push_back(old[i]);
  }
  for (int i = 0; i < fresh_count; ++i) {
    slots[i] = take_slot();
    tets_[std::size_t(slots[i])] = fresh[i];
  }
  const auto resolved = [&](int link) {
    return link > -2 ? link : 4 * slots[(-2 - link) / 4] + (-2 - link) % 4;
  };
  const auto set = [&](int from, int to) {
    if (from >= 0) links_[std::size_t(from / 4)][std::size_t(from % 4)] = to;
  };
  for (std::size_t i = 0; i < entries_.size(); i += 2) {
    const int a = resolved(entries_[i].link), b = resolved(entries_[i + 1].link);
    set(a, b);
    set(b, a);
  }
  return true;
}

void TetTopology::remove(const std::vector<int>& tets) {
  for (const int t : tets) {
    for (int& link : links_[std::size_t(t)]) {
      if (link >= 0) links_[std::size_t(link / 4)][std::size_t(link % 4)] = -1;
      link = -1;
    }
    tets_[std::size_t(t)][0] = -1;
    free_.push_back(t);
  }
}

}  // namespace angio::air_mesh
