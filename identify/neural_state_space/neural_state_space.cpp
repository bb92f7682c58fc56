// Free run of neural state-space models, and their files.

#include "identify/neural_state_space/neural_state_space.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/data/matching.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"
#include "identify/random.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void check(const NeuralStateSpace& m) {
  if (!m.transition || !m.output) fail("a neural state-space model needs a transition and an output");
  const int n = m.transition->outputs(), inputs = static_cast<int>(m.inputs.size());
  if (m.transition->inputs() != n + inputs)
    fail("the transition leads from {} numbers to {} states, but there are {} inputs; it needs {} numbers",
         m.transition->inputs(), n, inputs, n + inputs);
  if (m.output->inputs() != n + inputs && m.output->inputs() != n)
    fail("the output reads {} numbers; it reads {} states, or them and {} inputs", m.output->inputs(), n, inputs);
  if (m.output->outputs() != static_cast<int>(m.outputs.size()))
    fail("the output gives {} numbers, but there are {} outputs", m.output->outputs(), m.outputs.size());
  if (m.delay.size() != m.inputs.size()) fail("there are {} delays for {} inputs", m.delay.size(), m.inputs.size());
  if (std::any_of(m.delay.begin(), m.delay.end(), [](int d) { return d < 0; }))
    fail("a delay is a number of samples, 0 or more");
  if (m.deviations.size() != static_cast<Index>(m.outputs.size()))
    fail("there are {} deviations for {} outputs", m.deviations.size(), m.outputs.size());
  if (!(m.Ts > 0)) fail("the sampling time must be greater than 0 s");
}

MatrixXd delayed(const MatrixXd& u, const std::vector<int>& delay) {
  MatrixXd late = u;
  for (Index j = 0; j < u.cols(); ++j) {
    for (Index k = 0; k < u.rows(); ++k) late(k, j) = u(std::max<Index>(0, k - delay[static_cast<std::size_t>(j)]), j);
  }
  return late;
}

namespace {

void check_fits(const NeuralStateSpace& m, const DataSet& data) {
  check(m);
  check_signals(m.inputs, m.outputs, m.Ts, data);
  check_free_run(data);
}

class Runner {
 public:
  Runner(const NeuralStateSpace& model, const Experiment& experiment)
      : m_(model), y_(experiment.y), u_(delayed(experiment.u, model.delay)), n_(model.order()) {
    scratch_.resize(std::max(m_.transition->scratch_size(), m_.output->scratch_size()));
  }

  MatrixXd run(VectorXd x, Index samples) {
    MatrixXd y(samples, m_.output->outputs());
    VectorXd z(n_ + u_.cols()), now(y.cols());
    for (Index k = 0; k < samples; ++k) {
      z << x, u_.row(k).transpose();
      m_.output->evaluate(z.data(), now.data(), scratch_.data());
      y.row(k) = now.transpose();
      m_.transition->evaluate(z.data(), x.data(), scratch_.data());
    }
    return y;
  }

  // The most probable first state: downhill from the best ones of many guesses, on the first samples; from where that
  // ends on all of them.
  VectorXd first_state(Index samples, int count) {
    const Index few = std::min<Index>(samples, 200);
    std::vector<VectorXd> guesses = m_.x0;
    guesses.resize(std::min<std::size_t>(guesses.size(), 20));
    guesses.insert(guesses.begin(), VectorXd::Zero(n_));
    Random random(1);
    while (static_cast<int>(guesses.size()) < count) {
      VectorXd x(n_);
      for (double& value : x) value = 1.5 * random.normal();
      guesses.push_back(std::move(x));
    }
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < guesses.size(); ++i) {
      const double own = criterion(guesses[i], few, nullptr, nullptr);
      order.emplace_back(std::isfinite(own) ? own : std::numeric_limits<double>::infinity(), i);
    }
    std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    // The fewer samples there are, the more of the guesses are followed.
    const auto followed = static_cast<std::size_t>(2 + 10 * count / std::max<Index>(few, 20));
    order.resize(std::min(order.size(), followed));
    VectorXd best = VectorXd::Zero(n_);
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [value, i] : order) {
      VectorXd x = guesses[i];
      const double reached = descend(x, few);
      if (reached < least) {
        least = reached;
        best = x;
      }
    }
    if (few < samples) descend(best, samples);
    return best;
  }

 private:
  double descend(VectorXd& x, Index samples) {
    MatrixXd R;
    VectorXd g;
    double now = criterion(x, samples, &R, &g), lambda = 1e-2;
    for (int i = 0; i < 30 && std::isfinite(now); ++i) {
      MatrixXd damped = R;
      damped.diagonal() *= 1 + lambda;
      const VectorXd step = Eigen::LDLT<MatrixXd>(damped).solve(g);
      if (!step.allFinite() || step.norm() <= 1e-12 * (1 + x.norm())) break;
      MatrixXd R_new;
      VectorXd g_new;
      const VectorXd moved = x + step;
      const double then = criterion(moved, samples, &R_new, &g_new);
      if (then < now) {
        const bool little = now - then <= 1e-14 * now;
        x = moved;
        now = then;
        R.swap(R_new);
        g.swap(g_new);
        lambda = std::max(lambda / 10, 1e-12);
        if (little) break;
      } else {
        lambda *= 10;
        if (lambda > 1e10) break;
      }
    }
    return std::isfinite(now) ? now : std::numeric_limits<double>::infinity();
  }

  // With R = J'J + I/9 and g = J'e - x/9 when they are wanted.
  double criterion(const VectorXd& start, Index samples, MatrixXd* R, VectorXd* g) {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    constexpr double weight = 1.0 / 9;
    VectorXd x = start, z(n_ + u_.cols()), now(y_.cols());
    RowMajor f_z(n_, z.size()), g_z(y_.cols(), m_.output->inputs());
    MatrixXd by = MatrixXd::Identity(n_, n_);
    double sum = weight * start.squaredNorm();
    if (R != nullptr) {
      *R = weight * MatrixXd::Identity(n_, n_);
      *g = -weight * start;
    }
    for (Index k = 0; k < samples; ++k) {
      z << x, u_.row(k).transpose();
      m_.output->evaluate(z.data(), now.data(), scratch_.data());
      if (R != nullptr) m_.output->derivative(z.data(), g_z.data(), scratch_.data());
      for (Index o = 0; o < y_.cols(); ++o) {
        if (!std::isfinite(y_(k, o))) continue;
        const double scale = std::max(m_.deviations[o], 1e-12 * m_.output->y_scaling().scale[o]);
        const double error = (y_(k, o) - now[o]) / scale;
        sum += error * error;
        if (R == nullptr) continue;
        const VectorXd row = (g_z.row(o).head(n_) * by).transpose() / scale;
        R->noalias() += row * row.transpose();
        *g += row * error;
      }
      if (R != nullptr) {
        m_.transition->derivative(z.data(), f_z.data(), scratch_.data());
        by = (f_z.leftCols(n_) * by).eval();
      }
      m_.transition->evaluate(z.data(), x.data(), scratch_.data());
    }
    return sum;
  }

  const NeuralStateSpace& m_;
  const MatrixXd& y_;
  MatrixXd u_;
  Index n_;
  VectorXd scratch_;
};

Item map_item(const Mlp& map) {
  Item item;
  map.write(item);
  return item;
}

std::shared_ptr<const Mlp> map_of(const Item& item, std::string_view key) {
  Item section = item.at(key);
  section.only({"x_scaling", "y_scaling", "layers", "direct"});
  section.set("type", "mlp");
  return std::dynamic_pointer_cast<const Mlp>(read_approximator(section));
}

}  // namespace

std::vector<VectorXd> first_states(const NeuralStateSpace& model, const DataSet& data, Index samples, int guesses) {
  check_fits(model, data);
  std::vector<VectorXd> result;
  for (const Experiment& e : data.experiments)
    result.push_back(Runner(model, e).first_state(std::clamp<Index>(samples, 0, e.samples()), guesses));
  return result;
}

MatrixXd simulate_from(const NeuralStateSpace& model, const Experiment& experiment, const VectorXd& x0) {
  return Runner(model, experiment).run(x0, experiment.samples());
}

std::vector<MatrixXd> simulate(const NeuralStateSpace& model, const DataSet& data, StateStart start, Index samples) {
  std::vector<VectorXd> x0(data.experiments.size(), VectorXd::Zero(model.order()));
  if (start == StateStart::estimated) {
    x0 = first_states(model, data, samples);
  } else {
    check_fits(model, data);
  }
  std::vector<MatrixXd> result;
  for (std::size_t i = 0; i < x0.size(); ++i) result.push_back(simulate_from(model, data.experiments[i], x0[i]));
  return result;
}

Item to_item(const NeuralStateSpace& m) {
  Item x0 = Item::list(), delay = Item::list();
  for (const VectorXd& x : m.x0) x0.add(x);
  for (const int d : m.delay) delay.add(d);
  Item data = m.data;
  if (data.keys().empty()) data = channels_item(m.Ts, m.inputs, m.outputs);
  Item item;
  item.set("data", data)
      .set("order", m.order())
      .set("delay", delay)
      .set("transition", map_item(*m.transition))
      .set("output", map_item(*m.output))
      .set("deviations", m.deviations)
      .set("x0", x0);
  if (!m.fit.method.empty()) item.set("fit", to_item(m.fit));
  return item;
}

NeuralStateSpace neural_state_space_of(const Item& item) {
  item.only({"plantloop_model", "type", "data", "order", "delay", "transition", "output", "deviations", "x0", "fit"});
  NeuralStateSpace m;
  m.data = item.at("data");
  const DataSet channels = channels_of(m.data);
  m.inputs = channels.inputs;
  m.outputs = channels.outputs;
  m.Ts = channels.Ts;
  m.transition = map_of(item, "transition");
  m.output = map_of(item, "output");
  if (item.integer("order") != m.order())
    item.at("order").wrong(fmt::format("the transition has {} states, not {}", m.order(), item.integer("order")));
  // Files made by hand may leave these out.
  m.delay.assign(m.inputs.size(), 0);
  if (item.has("delay")) {
    m.delay.clear();
    for (const double d : item.vector("delay")) {
      if (!(d >= 0 && d <= 1e6) || d != std::floor(d))
        item.at("delay").wrong("a delay is a number of samples, 0 or more");
      m.delay.push_back(static_cast<int>(d));
    }
  }
  m.deviations = item.has("deviations") ? item.vector("deviations") : VectorXd(0.01 * m.output->y_scaling().scale);
  if (item.has("x0")) {
    const MatrixXd starts = item.matrix("x0", -1, m.order());
    for (Index i = 0; i < starts.rows(); ++i) m.x0.emplace_back(starts.row(i).transpose());
  }
  if (item.has("fit")) m.fit = fit_report_of(item.at("fit"));
  try {
    check(m);
  } catch (const IdentifyError& error) {
    item.wrong(error.what());
  }
  return m;
}

}  // namespace plantloop::identify
