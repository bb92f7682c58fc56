// A diagram as a predictor: its Program, differentiated exactly and stepped sample by sample.

#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/analysis/linear_program.h"
#include "learned/predictor.h"

namespace plantloop {

struct DiagramUse {
  std::string path;                          // of the file
  std::vector<std::string> inputs, outputs;  // signals of the diagram
  int substeps = 4;                          // of a sample, each a step of the classic method of order 4
  double Ts = 0;                             // s; 0: nothing is going to be predicted
  friend bool operator==(const DiagramUse&, const DiagramUse&) = default;
};

// The state is that of the diagram, in the order of its program: the continuous states or, of a sampled diagram, those
// of its one rate, of which a prediction takes one hit for each sample. So are the extras. Time stands still at the
// start of the diagram's own simulation.
class DiagramPredictor final : public Predictor {
 public:
  // Null after saying in `error` why the diagram cannot be used: something is wrong with it, a signal is not there, it
  // has events, delays or several rates, the input depends on its states, or the output on the input at once.
  static std::shared_ptr<const DiagramPredictor> make(const DiagramUse& use, std::string& error);

  // Of a sampled diagram: its period (s); 0: it is continuous.
  double own_period() const { return period_; }
  const std::vector<std::string>& state_names() const { return names_; }
  // The files it was made of, with their texts.
  const std::vector<std::pair<std::string, std::string>>& sources() const { return sources_; }

  int inputs() const override { return static_cast<int>(use_.inputs.size()); }
  int outputs() const override { return static_cast<int>(use_.outputs.size()); }
  int extras() const override { return state_size(); }
  int state_size() const override { return states_; }
  bool is_linear() const override { return is_affine_; }
  int dead_samples(int) const override { return 0; }
  std::size_t room(int horizon, int variables) const override;
  void output(const double* state, double* y, double* room) const override;
  void predict(const double* state, const double* u, int horizon, bool with_extras, double* signals,
               double* room) const override;
  void sensitivities(const double* u, int horizon, bool with_extras, const double* by_variables, int variables,
                     double* result, double* room) const override;
  void advance(const double* state, const double* u, double* next, double* room) const override;
  void start(const double* u, const double* y, double* state) const override;
  bool is_made_of_outputs() const override { return false; }

 private:
  struct Work;
  struct Entry {
    std::uint32_t row, column;  // of states, or outputs; of states, or inputs
    SlotIndex slot;
  };
  DiagramPredictor() = default;
  bool look_at(std::string& error);
  bool find_affine() const;
  bool sort_entries(const Program::PartialList& partials, std::size_t first_row, std::string& error);
  Work begin(double* room, int variables) const;
  void set_inputs(Work& work, const double* u) const;
  void follow_modes(Work& work) const;
  void derivatives(Work& work, const double* x, double* f) const;
  void step(Work& work, const double* u, double* x) const;
  void step_with_slopes(Work& work, const double* u, const double* by_u, int variables, double* x, double* X) const;
  void look(Work& work, const double* x, double* y) const;
  void add_slopes(const Work& work, const std::vector<Entry>& entries, const double* by, int variables,
                  double* to) const;
  SlotIndex state_slot(int i) const;

  DiagramUse use_;
  std::unique_ptr<LinearProgram> linear_;
  const Program* program_ = nullptr;
  const Program::PartialList* partials_ = nullptr;
  bool is_affine_ = false;
  std::vector<std::pair<std::string, std::string>> sources_;
  std::vector<std::string> names_;
  std::vector<double> start_, base_;  // states, and the inputs' wires when nothing is added to them
  int states_ = 0;
  double period_ = 0;
  std::vector<Entry> by_states_, by_inputs_, outputs_by_states_;
};

}  // namespace plantloop
