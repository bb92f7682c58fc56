// A compiled diagram is immutable and shared; each run has a Frame of its own.

#include "engine/analysis/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "engine/base/error.h"
#include "engine/base/numbers.h"
#include "engine/base/parallel.h"
#include "engine/block_random.h"

namespace plantloop {

namespace {

constexpr std::size_t most_points = 10'000'000;

// The same for equal paths on every machine (FNV-1a).
std::uint64_t stream_of(const std::string& path) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : path) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

double draw(const SweepPlan::Random& r, std::uint64_t seed, std::size_t number) {
  const double u = uniform_number(seed, stream_of(r.path), 0, number);
  if (r.distribution == "normal") return r.a + r.b * normal_quantile(u);
  if (r.distribution == "log_uniform") return r.a * std::exp(u * std::log(r.b / r.a));
  return r.a + (r.b - r.a) * u;
}

bool check(const SweepPlan& plan, Report& report) {
  const std::size_t errors = report.error_count();
  std::vector<std::string> paths;
  const auto once = [&](const std::string& path) {
    for (const std::string& other : paths) {
      if (other == path) report.error({}, "the sweep has '{}' twice", path);
    }
    paths.push_back(path);
  };
  for (const auto* values : {&plan.grid, &plan.list}) {
    for (const SweepPlan::Values& v : *values) {
      once(v.path);
      if (v.texts.empty()) report.error({}, "the sweep has no values for '{}'", v.path);
    }
  }
  for (const SweepPlan::Values& v : plan.list) {
    if (v.texts.size() != plan.list.front().texts.size()) {
      report
          .error({}, "the lists of a sweep go side by side: '{}' has {} values, '{}' has {}", plan.list.front().path,
                 plan.list.front().texts.size(), v.path, v.texts.size())
          .hint("for every combination of values take a grid");
    }
  }
  for (const SweepPlan::Random& r : plan.random) {
    once(r.path);
    std::vector<std::string> names;
    bool known = false;
    for (const DistributionInfo& d : distributions()) {
      names.emplace_back(d.name);
      known = known || d.name == r.distribution;
    }
    if (!known)
      report.error({}, "'{}': there is no distribution '{}'", r.path, r.distribution).suggest(r.distribution, names);
    else if (!std::isfinite(r.a) || !std::isfinite(r.b) || (r.distribution == "normal" ? r.b < 0 : r.b < r.a) ||
             (r.distribution == "log_uniform" && !(r.a > 0)))
      report.error({}, "'{}': {}({:g}, {:g}) is no distribution: it is {}", r.path, r.distribution, r.a, r.b,
                   r.distribution == "normal"        ? "normal(mean, deviation) with a deviation that is not negative"
                   : r.distribution == "log_uniform" ? "log_uniform(lower, upper) with 0 < lower and lower <= upper"
                                                     : "uniform(lower, upper) with lower <= upper");
  }
  if (!plan.random.empty() && plan.draws == 0) report.error({}, "a sweep with random parameters needs a draw or more");
  if (paths.empty()) report.error({}, "the sweep has no parameters").hint("give it a grid, a list or random ones");
  return report.error_count() == errors;
}

// Each row that there is, followed by each of the new ones.
void combine(std::vector<Overrides>& points, const std::vector<Overrides>& rows) {
  std::vector<Overrides> all;
  for (const Overrides& point : points) {
    for (const Overrides& row : rows) {
      all.push_back(point);
      all.back().insert(all.back().end(), row.begin(), row.end());
    }
  }
  points = std::move(all);
}

}  // namespace

const std::vector<DistributionInfo>& distributions() {
  static const std::vector<DistributionInfo> list{
      {"uniform", "lower, upper"}, {"log_uniform", "lower, upper"}, {"normal", "mean, deviation"}};
  return list;
}

std::optional<std::vector<Overrides>> sweep_points(const SweepPlan& plan, Report& report) {
  if (!check(plan, report)) return std::nullopt;
  double size = plan.random.empty() ? 1 : static_cast<double>(plan.draws);
  for (const SweepPlan::Values& v : plan.grid) size *= static_cast<double>(v.texts.size());
  if (!plan.list.empty()) size *= static_cast<double>(plan.list.front().texts.size());
  if (size > static_cast<double>(most_points)) {
    report.error({}, "the sweep has {:g} points, at most {} are possible", size, most_points);
    return std::nullopt;
  }
  std::vector<Overrides> points(1);
  for (const SweepPlan::Values& v : plan.grid) {
    std::vector<Overrides> rows;
    for (const std::string& text : v.texts) rows.push_back({{v.path, text}});
    combine(points, rows);
  }
  if (!plan.list.empty()) {
    std::vector<Overrides> rows(plan.list.front().texts.size());
    for (const SweepPlan::Values& v : plan.list) {
      for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back({v.path, v.texts[i]});
    }
    combine(points, rows);
  }
  if (!plan.random.empty()) {
    std::vector<Overrides> rows(plan.draws);
    for (const SweepPlan::Random& r : plan.random) {
      for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back({r.path, shortest(draw(r, plan.seed, i))});
    }
    combine(points, rows);
  }
  return points;
}

std::optional<std::vector<SweepPoint>> sweep(Diagram& diagram, const SweepRequest& request, Report& report,
                                             const SweepControl& control) {
  std::vector<SweepPoint> points(request.points.size());
  std::vector<Report> findings(points.size());
  std::vector<char> wrong(points.size(), 0);
  std::mutex telling;
  std::size_t done = 0;
  const auto began = std::chrono::steady_clock::now();
  const auto seconds_left = [&] {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began;
    return std::max(1e-3, control.time_limit - passed.count());
  };
  const auto run_one = [&](std::size_t i) {
    SweepPoint& point = points[i];
    point.set = request.points[i];
    RunRequest run = request.run;
    run.set.insert(run.set.end(), point.set.begin(), point.set.end());
    RunControl watch;
    watch.cancel = control.cancel;
    if (control.time_limit > 0) watch.time_limit = seconds_left();
    try {
      point.run = diagram.run(run, findings[i], watch);
      if (!point.run) {
        wrong[i] = 1;
        point.failure = to_text(findings[i]);
      }
    } catch (const LimitError& e) {
      const bool cancelled = control.cancel != nullptr && control.cancel->load();
      if (cancelled || (control.time_limit > 0 && seconds_left() <= 1e-3)) throw;
      point.failure = e.what();
    } catch (const RunError& e) {
      point.failure = e.what();
    }
    if (request.finished) request.finished(i, point);
    const std::lock_guard lock(telling);
    ++done;
    if (control.progress) control.progress(done, points.size());
  };
  in_parallel(points.size(), thread_count(request.threads), run_one);
  bool all_wrong = !points.empty();
  for (const char w : wrong) all_wrong = all_wrong && w != 0;
  if (!all_wrong) return points;
  report.append(std::move(findings.front()));
  return std::nullopt;
}

}  // namespace plantloop
