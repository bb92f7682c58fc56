// Which order and which delay: tables of candidates.

#pragma once

#include <vector>

#include "identify/linear/fit_linear.h"

namespace plantloop::identify {

// An ARX structure and what it reached. All candidates of a table are fitted to the same rows, so that their criteria
// can be compared.
struct ArxCandidate {
  Orders orders;
  int parameters = 0;
  double sse = 0;                    // of the one-step error over the table's rows
  double aic = 0, mdl = 0, fpe = 0;  // as in validation/metrics.h
  double simulated = 0;  // RMSE of the free run from the first measured samples; infinite when it is unstable
};

struct OrderRange {
  int na_least = 1, na_most = 4;
  int nb_least = 1, nb_most = 4;
  int delay_least = 0, delay_most = 3;  // the same nb and delay for every input
};

struct ArxTable {
  std::vector<ArxCandidate> candidates;  // by na, nb, delay
  long long rows = 0;
  // Places in `candidates` of the least AIC, MDL, FPE and simulated error.
  std::size_t best_aic = 0, best_mdl = 0, best_fpe = 0, best_simulated = 0;
};

// Every combination in the ranges, by one QR decomposition for all. The free run is on `validation` when there is one,
// else on the data.
ArxTable arx_table(const DataSet& data, const OrderRange& range, const LinearOptions& options = {},
                   const DataSet* validation = nullptr, const FitControl& control = {});

// det(Psi'Psi/N) of ARX models of order n = 1 ... highest with na = nb = n: it falls to nothing when n exceeds the
// order of the process (the book's (2.15), without its misprinted inverse). `order` is where the ratio of neighbours
// jumps most.
struct InformationTest {
  std::vector<double> determinants;
  int order = 1;
};
InformationTest information_test(const DataSet& data, int highest, int delay, const LinearOptions& options = {});

// RMSE of output-error models in free run for each delay; of unstable ones it is infinite. The minimum is the delay:
// with noise, ARX models are biased so that theirs is not (see the guide).
struct DelayCandidate {
  int delay = 0;
  double rmse = 0;
};
std::vector<DelayCandidate> delay_table(const DataSet& data, int order, int delay_least, int delay_most,
                                        const LinearOptions& options = {}, const FitControl& control = {});

}  // namespace plantloop::identify
