#include <fstream>

#include "simulation/step/make_views.hpp"
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
class CpuSolver final : public StepSolver {
 public:
  CpuSolver(const Scene& scene, const SimulationOptions& options, int threads)
      : scene_(scene),
        view_(make_view<Real>(scene, options, memory_)),
        options_(options),
        rules_(make_rules(scene, options)),
        plasticity_(plastic_flow<Real>(options.wall)),
        finder_(scene, options, kFramesToLast, false),
        threads_(threads > 0 ? threads
                             : std::clamp(scene.vertex_count() / kVerticesPerThread, 1,
                                          omp_get_max_threads())) {
    if (view_.paper_gas.is_on) gas_ = paper_gas_tets(scene);
    status_.pressure = outside_pressure(options);
    status_.volume = balloon_volume(scene, scene.start);
  }

  void run(const Inflator& inflator,
           const std::function<void(int frame, const State& state)>& on_state) override {
    Inflator schedule = inflator;
    on_state(0, start_state(scene_, status_.pressure));
    for (int frame = 1; frame < schedule.frame_count(); ++frame) {
      status_.law = schedule.law(frame, status_.pressure * status_.volume, status_.volume);
      if (push_) push(frame);
      step(rules_);
      on_state(frame, state());
    }
  }

  State settle(const GasLaw<double>& law, double tolerance, int most_sweeps) override {
    StepRules rules = rules_;
    rules.tolerance = rules.residual = tolerance;
    rules.rest = 0.0;
    rules.most_sweeps = rules.later_sweeps = most_sweeps;
    rules.still = true;
    status_.law = law;
    step(rules);
    return state();
  }

  [[nodiscard]] std::string device() const override { return processor_name(); }

  // A tet that stays keeps its viscous item.
  void set_air(const std::vector<Tet>& air) override {
    PaperContact<Real>& paper = view_.paper;
    if (!paper.is_on || air.empty()) return;
    PaperTets now = paper_tets(scene_, options_, air);
    triggered_ = kept_items(air_, triggered_, now);
    air_ = std::move(now);
    paper.colors = int(air_.color_begin.size()) - 1;
    paper.color_begin = air_.color_begin.data();
    paper.tets = air_.vertices.data();
    paper.balloon_corners = air_.balloon_corners.data();
    paper.triggered = triggered_.data();
  }

  void set_push(const Push& push) override { push_ = push; }

 private:
  void push(int frame) {
    std::vector<Vec3> velocity(scene_.start.size());
    for (std::size_t v = 0; v < velocity.size(); ++v)
      velocity[v] = converted<double>(view_.velocity[v]);
    push_(frame, global(scene_, view_.start, view_.x), velocity);
    for (std::size_t v = 0; v < velocity.size(); ++v)
      view_.velocity[v] = converted<Real>(velocity[v]);
  }

  void step(const StepRules& rules) {
    if (has_pairs<CpuTeam>(view_) && view_.candidates == nullptr) renew_candidates();
    ++frames_lasted_;
    bool done = false;
    do {
      run_on_cpu(threads_, shared_, [&](CpuTeam& team) {
        StepStatus status = status_;
        const bool ended = run_step(team, view_, rules, plasticity_, status);
        team.barrier();
        if (!team.leader()) return;
        status_ = status;
        done = ended;
      });
      if (!done) renew_candidates();
    } while (!done);
  }

  void renew_candidates() {
    set_ = finder_.find(positions(), frames_lasted_);
    frames_lasted_ = 0;
    x_candidates_.assign(view_.x, view_.x + scene_.vertex_count());
    pairs_.resize(set_.candidates.size());
    refs_.resize(4 * set_.candidates.size());
    bounds_.resize(4 * set_.candidates.size());
    listed_begin_.resize(scene_.start.size());
    use<Real>({set_.candidates.data(), set_.owned_begin.data(), listed_begin_.data(), nullptr,
               x_candidates_.data(), Real(set_.reach), int(set_.candidates.size()),
               Real(set_.skin_reach)},
              view_);
    view_.pairs = pairs_.data();
    view_.listed_begin = listed_begin_.data();
    view_.refs = refs_.data();
    view_.bounds = bounds_.data();
  }

  // Relative to the origin.
  std::vector<Vec3> positions() const {
    std::vector<Vec3> x(scene_.start.size());
    for (std::size_t v = 0; v < x.size(); ++v) x[v] = converted<double>(view_.x[v]);
    return x;
  }

  State state() const {
    State state;
    state.x = global(scene_, view_.start, view_.x);
    for (int c = 0; c < view_.cluster_count; ++c)
      state.plastic.push_back(converted<double>(view_.cluster_plastic[c]));
    for (int i = 0; view_.cluster_plastic_modes && i < view_.cluster_count * kShapeModes; ++i)
      state.plastic_modes.push_back(converted<double>(view_.cluster_plastic_modes[i]));
    for (int i = 0; i < view_.wall_count; ++i)
      state.contact_pressure.push_back(double(view_.contact_pressure[i]));
    for (int p = 0; p < kWedgePoints * view_.wedge_count; ++p) {
      state.solid_points.push_back(converted<double>(view_.solid_points[p]));
      state.solid_plastic_strain.push_back(double(view_.solid_plastic_strain[p]));
    }
    state.pressure = view_.paper_gas.is_on ? mean_tet_pressure(gas_, status_.tet_growth,
                                                               outside_pressure(options_), state.x)
                                           : status_.pressure;
    state.volume = status_.volume;
    state.report = status_.report;
    return state;
  }

  const Scene& scene_;
  HostMemory memory_;
  StepView<Real> view_;
  SimulationOptions options_;
  PaperGasTets gas_;  // of the paper's gas
  PaperTets air_;     // of the paper's contact, once the mesh has followed
  std::vector<char> triggered_;
  StepRules rules_;
  PlasticFlow<Real> plasticity_;
  CandidateFinder finder_;
  CandidateSet set_;
  int frames_lasted_ = 0;
  std::vector<Vec3T<Real>> x_candidates_;
  std::vector<NearPair<Real>> pairs_;
  std::vector<int> listed_begin_;
  std::vector<ContactRef> refs_;
  std::vector<MotionBound<Real>> bounds_;
  StepStatus status_;
  Push push_;
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
