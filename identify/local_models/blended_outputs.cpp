// Local models that run side by side, each on its own past.

#include <algorithm>

#include "identify/data/matching.h"
#include "identify/error.h"
#include "identify/local_models/local_model_network.h"
#include "identify/narx/regressor_row.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Outputs simulate_blended_outputs(const NarxModel& model, const DataSet& data) {
  const auto* network = dynamic_cast<const LocalModelNetwork*>(model.map.get());
  if (network == nullptr)
    fail("outputs can be blended in a network of local models only, this is '{}'", model.map->type());
  const Index first = model.regressors.longest_lag(), d = network->inputs();
  const std::size_t m = network->models().size();
  check_data(model, data);
  check_free_run(data, first);
  Outputs outputs;
  for (const Experiment& experiment : data.experiments) {
    MatrixXd blended = experiment.y;
    std::vector<MatrixXd> own(m, blended);
    VectorXd x(d + 1), mu(static_cast<Index>(m));
    x[d] = 1;
    for (Index k = first; k < blended.rows(); ++k) {
      fill_row(model.regressors, experiment.u, blended, k, x.data());
      network->weights(x.data(), mu.data());
      blended.row(k).setZero();
      for (std::size_t i = 0; i < m; ++i) {
        fill_row(model.regressors, experiment.u, own[i], k, x.data());
        own[i].row(k) = (network->models()[i].parameters * x).transpose();
        blended.row(k) += mu[static_cast<Index>(i)] * own[i].row(k);
      }
    }
    outputs.push_back(std::move(blended));
  }
  return outputs;
}

}  // namespace plantloop::identify
