// Polynomial models in model files.

#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/polynomial_model.h"

namespace plantloop::identify {
namespace {

using Eigen::VectorXd;

Item channel_item(const Channel& c) {
  Item item;
  item.set("name", c.name);
  if (!c.unit.empty()) item.set("unit", c.unit);
  return item;
}

VectorXd monic_of(const Item& item, std::string_view key) {
  VectorXd P = item.vector(key);
  if (P.size() == 0 || P[0] != 1 || !P.allFinite()) {
    item.at(key).wrong(fmt::format("'{}' must be finite numbers of which the first is 1", key));
  }
  return P;
}

}  // namespace

Item to_item(const PolynomialModel& m) {
  Item inputs = Item::list();
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    Item input = channel_item(m.inputs[i]);
    input.set("delay", m.delay[i]).set("B", m.B[i]).set("F", m.F[i]).set("operating_point", m.u0[static_cast<int>(i)]);
    inputs.add(std::move(input));
  }
  Item output = channel_item(m.output);
  output.set("operating_point", m.y0);
  if (m.has_offset) output.set("offset", m.offset);
  Item item;
  item.set("structure", m.structure)
      .set("Ts", m.Ts)
      .set("output", output)
      .set("A", m.A)
      .set("C", m.C)
      .set("D", m.D)
      .set("inputs", inputs);
  if (m.initial == Initial::estimate) item.set("initial", "estimate");
  item.set("variance", m.variance)
      .set("parameter_names", m.parameter_names())
      .set("covariance", m.covariance)
      .set("fit", to_item(m.fit));
  return item;
}

PolynomialModel polynomial_model_of(const Item& item) {
  item.only({"plantloop_model", "type", "data", "structure", "Ts", "output", "A", "C", "D", "inputs", "initial",
             "variance", "parameter_names", "covariance", "fit"});
  PolynomialModel m;
  m.structure = item.text("structure");
  m.Ts = item.number("Ts");
  if (!(m.Ts > 0)) item.at("Ts").wrong("the sampling time 'Ts' must be greater than 0 s");
  const Item& output = item.at("output");
  output.only({"name", "unit", "operating_point", "offset"});
  m.output = {output.text("name"), output.has("unit") ? output.text("unit") : ""};
  m.y0 = output.number("operating_point");
  m.has_offset = output.has("offset");
  if (m.has_offset) m.offset = output.number("offset");
  m.A = monic_of(item, "A");
  m.C = monic_of(item, "C");
  m.D = monic_of(item, "D");
  std::vector<double> u0;
  for (const Item& input : item.items("inputs")) {
    input.only({"name", "unit", "delay", "B", "F", "operating_point"});
    m.inputs.push_back({input.text("name"), input.has("unit") ? input.text("unit") : ""});
    m.delay.push_back(static_cast<int>(input.integer("delay")));
    if (m.delay.back() < -1 || m.delay.back() > 1'000'000) input.at("delay").wrong("'delay' is -1 or more samples");
    m.B.push_back(input.vector("B"));
    m.F.push_back(monic_of(input, "F"));
    u0.push_back(input.number("operating_point"));
  }
  m.u0 = Eigen::Map<const VectorXd>(u0.data(), static_cast<Eigen::Index>(u0.size()));
  if (item.has("initial")) {
    const std::string initial = item.text("initial");
    if (initial != "rest" && initial != "estimate") item.at("initial").wrong("'initial' is rest or estimate");
    if (initial == "estimate") m.initial = Initial::estimate;
  }
  if (m.structure != structure_name(m.orders()))
    item.at("structure")
        .wrong(fmt::format("the polynomials are those of '{}', not of '{}'", structure_name(m.orders()), m.structure));
  m.variance = item.number("variance");
  const Eigen::Index p = m.parameters().size();
  m.covariance = item.matrix("covariance", p, p);
  m.fit = fit_report_of(item.at("fit"));
  return m;
}

}  // namespace plantloop::identify
