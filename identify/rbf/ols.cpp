// Forward selection by orthogonal least squares.

#include "identify/error.h"
#include "identify/rbf/rbf_network.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

OlsSelection select_columns(MatrixXd P, const MatrixXd& D, int most, double tolerance) {
  OlsSelection selection;
  const double total = D.squaredNorm();
  if (!(total > 0)) return selection;
  const VectorXd least = 1e-10 * P.colwise().squaredNorm();
  double left = 1;
  for (int round = 0; round < most && left > tolerance; ++round) {
    const MatrixXd products = D.transpose() * P;
    Index best = -1;
    double best_ratio = 0;
    for (Index c = 0; c < P.cols(); ++c) {
      const double square = P.col(c).squaredNorm();
      if (!(square > least[c])) continue;
      const double ratio = products.col(c).squaredNorm() / square / total;
      if (best < 0 || ratio > best_ratio) best = c, best_ratio = ratio;
    }
    if (best < 0) break;
    selection.columns.push_back(best);
    selection.ratios.push_back(best_ratio);
    left -= best_ratio;
    // Modified Gram-Schmidt: what the chosen column explains is taken from all others at once.
    const VectorXd w = P.col(best).normalized();
    const Eigen::RowVectorXd shares = w.transpose() * P;
    P.noalias() -= w * shares;
    P.col(best).setZero();
  }
  return selection;
}

}  // namespace plantloop::identify
