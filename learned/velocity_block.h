// What the blocks of velocity-form models share: the file, the filter of the input, and the integration.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/block.h"
#include "identify/velocity/velocity_family.h"

namespace plantloop {

// ud = N (u - uf), uf' = ud;  w' = A w + B ud,  y' = C w + D ud, with matrices that a block makes of its file's.
struct VelocityBlock : Block {
  Text model{
      this, "model", {.doc = "the file of type velocity_family, as the script function writes it", .file = true}};
  Input u{this, "u", {.doc = "inputs of the models, in their order", .size = any_size}};
  Number N{this,
           "N",
           {.init = 100, .unit = "rad/s", .doc = "pole of the filter that gives the inputs' derivatives", .above = 0}};
  Table start{this,
              "initial",
              {.doc = "outputs at the start; default: those of the first point; may read signals",
               .optional = true,
               .initial = true}};
  Table rates_at_start{this,
                       "initial_rates",
                       {.init = "0", .doc = "derivatives of the states at the start; 0: at rest", .initial = true}};
  State w{this, "w", {.doc = "derivatives of the models' states", .size = any_size}};
  State uf{this, "uf", {.doc = "filtered inputs", .size = any_size}};
  State integral{this, "y", {.doc = "outputs", .size = any_size}};

  void initial(Now now, Init init) const override;
  void derivatives(Now now, Rates rate) const override;

 protected:
  // The family, null when the file cannot be used; `error` says why.
  std::shared_ptr<const identify::VelocityFamily> family(std::string* error = nullptr) const;
  // Reports what is wrong with the file or with sizes of parameters; the family when nothing is.
  std::shared_ptr<const identify::VelocityFamily> checked(Checking& checking) const;
  void set_sizes(Sizing& sizing, const Output& output) const;
  // The weight of each point.
  virtual std::vector<Value> weights(Now now, const identify::VelocityFamily& family) const = 0;
};

}  // namespace plantloop
