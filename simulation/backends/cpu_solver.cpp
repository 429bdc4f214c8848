#include <fstream>

#include "simulation/backends/host_memory.hpp"
#include "simulation/backends/solver_base.hpp"
#include "simulation/step/program.hpp"
#include "simulation/step/team.hpp"

namespace angio::simulation::detail {
namespace {

// Frames that a set of contact candidates should last.
constexpr int kFramesToLast = 2;
// Vertices a thread must have to be worth waking.
constexpr int kVerticesPerThread = 3000;

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  std::string line;
  while (std::getline(info, line))
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "CPU";
}

template <class Real>
class CpuSolver final : public SolverBase<Real> {
 public:
  CpuSolver(const Scene& scene, const SimulationOptions& options, int threads)
      : SolverBase<Real>(scene, options),
        finder_(scene, options, kFramesToLast),
        view_(make_view<Real>(scene, options, memory_)),
        threads_(threads > 0 ? threads
                             : std::clamp(scene.vertex_count() / kVerticesPerThread, 1,
                                          omp_get_max_threads())) {}

  void run(const Control& control,
           const std::function<void(int frame, State&& state)>& on_state) override {
    Inflator inflator = control.inflator;
    on_state(0, start_state(scene_, status_.pressure));
    for (int frame = 1; frame < inflator.frame_count(); ++frame) {
      status_.law = inflator.law(frame, status_.pressure * status_.volume, status_.volume);
      if (push_) push(frame);
      on_state(frame, take_step(control.rules));
    }
  }

  [[nodiscard]] std::string device() const override { return processor_name(); }

  void set_push(const StepSolver::Push& push) override { push_ = push; }

  void put(const std::vector<Vec3>& x) override {
    const std::vector<Vec3> before = global(scene_, view_.motion.start, view_.motion.x);
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (x[v] == before[v]) continue;
      view_.motion.x[v] += converted<Real>(x[v] - before[v]);
      view_.motion.velocity[v] = {};
    }
    view_.contact.candidates.list = nullptr;  // they are those of another place
  }

 private:
  using SolverBase<Real>::scene_;
  using SolverBase<Real>::status_;

  void push(int frame) {
    std::vector<Vec3> velocity(scene_.start.size());
    for (std::size_t v = 0; v < velocity.size(); ++v)
      velocity[v] = converted<double>(view_.motion.velocity[v]);
    push_(frame, global(scene_, view_.motion.start, view_.motion.x), velocity);
    for (std::size_t v = 0; v < velocity.size(); ++v)
      view_.motion.velocity[v] = converted<Real>(velocity[v]);
  }

  State take_step(const StepRules& rules) override {
    if (has_pairs<CpuTeam>(view_) && view_.contact.candidates.list == nullptr) renew_candidates();
    ++frames_lasted_;
    bool done = false;
    do {
      run_on_cpu(threads_, shared_, [&](CpuTeam& team) {
        StepStatus status = status_;
        const bool ended = run_step(team, view_, rules, this->plasticity_, status);
        team.barrier();
        if (!team.leader()) return;
        status_ = status;
        done = ended;
      });
      if (!done) renew_candidates();
    } while (!done);
    return this->state_of(state_view(view_), status_);
  }

  void renew_candidates() {
    x_candidates_.assign(view_.motion.x, view_.motion.x + scene_.vertex_count());
    std::vector<Vec3> points;
    points.reserve(x_candidates_.size());
    for (const Vec3T<Real>& p : x_candidates_) points.push_back(converted<double>(p));
    set_ = finder_.find(points, frames_lasted_);
    radii_ = {Real(set_.radii.search), Real(set_.radii.self)};
    frames_lasted_ = 0;
    const std::size_t count = set_.candidates.size();
    pairs_.resize(count);
    refs_.resize(4 * count);
    bounds_.resize(4 * count);
    listed_begin_.resize(scene_.start.size());
    NearPairView<Real>& near = view_.contact.near;
    near.pairs = pairs_.data();
    near.listed_begin = listed_begin_.data();
    near.refs = refs_.data();
    near.bounds = bounds_.data();
    view_.contact.candidates = {int(count),
                                set_.candidates.data(),
                                set_.owned_begin.data(),
                                near.listed_begin,
                                nullptr,
                                x_candidates_.data(),
                                &radii_};
  }

  std::vector<char> viscous_items(std::size_t) override { return viscous_items_; }

  void use_tets(const PbdTets& tets, std::vector<char> viscous_items) override {
    viscous_items_ = std::move(viscous_items);
    PbdContact<Real>& contact = view_.pbd.contact;
    contact.tet_count = int(tets.balloon_corners.size());
    contact.colors = int(tets.color_begin.size()) - 1;
    contact.color_begin = tets.color_begin.data();
    contact.tets = tets.vertices.data();
    contact.balloon_corners = tets.balloon_corners.data();
    contact.triggered = viscous_items_.data();
  }

  CandidateFinder finder_;
  HostMemory memory_;
  StepView<Real> view_;
  std::vector<char> viscous_items_;  // of the reference method's tets, once the air has followed
  CandidateSet set_;
  std::vector<Vec3T<Real>> x_candidates_;  // where they were found
  SearchRadii<Real> radii_;
  int frames_lasted_ = 0;
  std::vector<NearPair<Real>> pairs_;
  std::vector<int> listed_begin_;
  std::vector<ContactRef> refs_;
  std::vector<MotionBound<Real>> bounds_;
  StepSolver::Push push_;
  CpuTeam::Shared shared_;
  int threads_;
};

}  // namespace

std::unique_ptr<StepSolver> make_cpu_solver(const Scene& scene, const SimulationOptions& options,
                                            Precision precision, int threads) {
  if (precision == Precision::automatic) precision = precision_for(scene, options);
  if (precision == Precision::single)
    return std::make_unique<CpuSolver<float>>(scene, options, threads);
  return std::make_unique<CpuSolver<double>>(scene, options, threads);
}

}  // namespace angio::simulation::detail
