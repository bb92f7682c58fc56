// What the blocks of velocity-form models share: the file, the filter of the input, and the integration.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/block.h"
#include "identify/velocity/velocity_family.h"

namespace plantloop {

// ud = N (u - uf), uf' = ud;  w' = A w + B ud,  y' = C w + D ud, with matrices that a block makes of its file's. Of a
// file of a sampled system w(t + Ts) = A w(t) + B ud(t): no sampled block, but a continuous one with a dead time, whose
// y comes to the system's next sample in each sampling time (book equations 5.15 to 5.17).
struct VelocityBlock : Block {
  Text model{
      this, "model", {.doc = "the file of type velocity_family, as the script function writes it", .file = true}};
  Input u{this, "u", {.doc = "inputs of the models, in their order", .size = any_size}};
  Number N{
      this,
      "N",
      {.unit = "rad/s",
       .doc = "pole of the filter that gives the inputs' derivatives; default: 100 rad/s, of a sampled system 100 in "
              "a sampling time",
       .above = 0,
       .optional = true}};
  Table start{this,
              "initial",
              {.doc = "outputs at the start; default: those of the first point; may read signals",
               .optional = true,
               .initial = true}};
  Table rates_at_start{
      this,
      "initial_rates",
      {.init = "0",
       .doc = "derivatives of the states at the start, of a sampled system by how much its first sample "
              "changes them; 0: at rest",
       .initial = true}};
  Table input_at_start{this,
                       "initial_input",
                       {.doc = "inputs before the start; default: those at the start; may read signals",
                        .optional = true,
                        .initial = true}};
  State w{this,
          "w",
          {.doc = "derivatives of the models' states; of a sampled system what is to come of the first change",
           .size = any_size}};
  State uf{this, "uf", {.doc = "filtered inputs", .size = any_size}};
  State integral{this, "y", {.doc = "outputs", .size = any_size}};

  void initial(Now now, Init init) const override;
  void derivatives(Now now, Rates rate) const override;

 protected:
  // The family, null when the file cannot be used; `error` says why.
  std::shared_ptr<const identify::VelocityFamily> family(std::string* error = nullptr) const;
  // Reports what is wrong with the file; the family when nothing is.
  std::shared_ptr<const identify::VelocityFamily> checked(Checking& checking) const;
  void set_sizes(Sizing& sizing, const Output& output, const Output& filtered) const;
  // The weight of each point, in the matrices A and C and in those of the input, B and D.
  struct Weights {
    std::vector<Value> of_states, of_inputs;
  };
  virtual Weights weights(Now now, const identify::VelocityFamily& family) const = 0;
};

}  // namespace plantloop
