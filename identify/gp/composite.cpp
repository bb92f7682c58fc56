// Sums and products of covariances, part by part.

#include "identify/gp/composite.h"

#include <fmt/format.h>

#include <cmath>

#include "identify/gp/gaussian_terms.h"

namespace plantloop::identify {
namespace {

using Parts = std::vector<std::shared_ptr<const Covariance>>;

class Composite : public Covariance {
 public:
  Composite(Parts parts, char sign) : parts_(std::move(parts)), sign_(sign) {}

  std::string name() const override {
    std::string text;
    for (const auto& part : parts_) {
      if (!text.empty()) text += sign_ == '+' ? " + " : "*";
      const std::string name = part->name();
      text += sign_ == '*' && name.find('+') != std::string::npos ? "(" + name + ")" : name;
    }
    return text;
  }
  std::vector<std::string> names(int inputs) const override {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      for (const std::string& name : parts_[i]->names(inputs)) names.push_back(fmt::format("{}.{}", i + 1, name));
    }
    return names;
  }
  Vector guess(const Matrix& x, double variance) const override {
    const double share = sign_ == '+' ? variance / static_cast<double>(parts_.size())
                                      : std::pow(variance, 1.0 / static_cast<double>(parts_.size()));
    Vector all(count(static_cast<int>(x.cols())));
    Eigen::Index at = 0;
    for (const auto& part : parts_) {
      const Vector own = part->guess(x, share);
      all.segment(at, own.size()) = own;
      at += own.size();
    }
    return all;
  }

 protected:
  // Calls f(i, theta of part i).
  template <typename F>
  void each(const Vector& theta, int inputs, F f) const {
    Eigen::Index at = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const int n = parts_[i]->count(inputs);
      f(i, Vector(theta.segment(at, n)), at);
      at += n;
    }
  }
  Parts parts_;

 private:
  char sign_;
};

class Sum final : public Composite {
 public:
  explicit Sum(Parts parts) : Composite(std::move(parts), '+') {}

  Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const override {
    Matrix total = Matrix::Zero(x.rows(), z.rows());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, auto) { total += parts_[i]->between(own, x, z); });
    return total;
  }
  Matrix lower(const Vector& theta, const Matrix& x) const override {
    Matrix total = Matrix::Zero(x.rows(), x.rows());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, auto) { total += parts_[i]->lower(own, x); });
    return total;
  }
  Vector at(const Vector& theta, const Matrix& x) const override {
    Vector total = Vector::Zero(x.rows());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, auto) { total += parts_[i]->at(own, x); });
    return total;
  }
  Vector gradient(const Vector& theta, const Matrix& x, const Matrix&, const Matrix& weight) const override {
    Vector all(theta.size());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, Eigen::Index first) {
      all.segment(first, own.size()) = parts_[i]->gradient(own, x, parts_[i]->lower(own, x), weight);
    });
    return all;
  }
  Vector cross_gradient(const Vector& theta, const Matrix& x, const Matrix& z, const Matrix&, const Matrix& weight,
                        Matrix* by_z) const override {
    Vector all(theta.size());
    if (by_z != nullptr) by_z->setZero(z.rows(), z.cols());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, Eigen::Index first) {
      Matrix part;
      all.segment(first, own.size()) = parts_[i]->cross_gradient(own, x, z, parts_[i]->between(own, x, z), weight,
                                                                 by_z == nullptr ? nullptr : &part);
      if (by_z != nullptr) *by_z += part;
    });
    return all;
  }
  Vector own_gradient(const Vector& theta, const Matrix& x, const Vector& weight) const override {
    Vector all(theta.size());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, Eigen::Index first) {
      all.segment(first, own.size()) = parts_[i]->own_gradient(own, x, weight);
    });
    return all;
  }
  Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const override {
    Matrix total = Matrix::Zero(z.rows(), z.cols());
    each(theta, inputs(z),
         [&](std::size_t i, const Vector& own, auto) { total += parts_[i]->input_gradient(own, x, z); });
    return total;
  }
  Matrix slope_covariance(const Vector& theta, const Vector& x) const override {
    Matrix total = Matrix::Zero(x.size(), x.size());
    bool known = true;
    each(theta, static_cast<int>(x.size()), [&](std::size_t i, const Vector& own, auto) {
      const Matrix part = parts_[i]->slope_covariance(own, x);
      if (part.size() == 0) known = false;
      if (known) total += part;
    });
    return known ? total : Matrix();
  }
  bool slopes(const Vector& theta, const Vector& x, const Vector& z, Matrix& block,
              std::vector<Matrix>* by_theta) const override {
    block = Matrix::Zero(x.size() + 1, x.size() + 1);
    if (by_theta != nullptr) by_theta->clear();
    bool known = true;
    each(theta, static_cast<int>(x.size()), [&](std::size_t i, const Vector& own, auto) {
      Matrix part;
      std::vector<Matrix> by_own;
      known = known && parts_[i]->slopes(own, x, z, part, by_theta == nullptr ? nullptr : &by_own);
      if (known) block += part;
      if (known && by_theta != nullptr) by_theta->insert(by_theta->end(), by_own.begin(), by_own.end());
    });
    return known;
  }
  bool terms(const Vector& theta, int inputs, std::vector<GaussianTerm>& list) const override {
    bool known = true;
    each(theta, inputs,
         [&](std::size_t i, const Vector& own, auto) { known = known && parts_[i]->terms(own, inputs, list); });
    return known;
  }

 private:
  static int inputs(const Matrix& x) { return static_cast<int>(x.cols()); }
};

class Product final : public Composite {
 public:
  explicit Product(Parts parts) : Composite(std::move(parts), '*') {}

  Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const override {
    Matrix product = Matrix::Ones(x.rows(), z.rows());
    each(theta, inputs(x),
         [&](std::size_t i, const Vector& own, auto) { product.array() *= parts_[i]->between(own, x, z).array(); });
    return product;
  }
  Matrix lower(const Vector& theta, const Matrix& x) const override {
    Matrix product = Matrix::Ones(x.rows(), x.rows()).triangularView<Eigen::Lower>();
    each(theta, inputs(x),
         [&](std::size_t i, const Vector& own, auto) { product.array() *= parts_[i]->lower(own, x).array(); });
    return product;
  }
  Vector at(const Vector& theta, const Matrix& x) const override {
    Vector product = Vector::Ones(x.rows());
    each(theta, inputs(x),
         [&](std::size_t i, const Vector& own, auto) { product.array() *= parts_[i]->at(own, x).array(); });
    return product;
  }
  // The product of the other factors goes into the weight of each one.
  Vector gradient(const Vector& theta, const Matrix& x, const Matrix&, const Matrix& weight) const override {
    std::vector<Matrix> values;
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, auto) { values.push_back(parts_[i]->lower(own, x)); });
    Vector all(theta.size());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, Eigen::Index first) {
      Matrix rest = weight.triangularView<Eigen::Lower>();
      for (std::size_t j = 0; j < values.size(); ++j) {
        if (j != i) rest.array() *= values[j].array();
      }
      all.segment(first, own.size()) = parts_[i]->gradient(own, x, values[i], rest);
    });
    return all;
  }
  Vector cross_gradient(const Vector& theta, const Matrix& x, const Matrix& z, const Matrix&, const Matrix& weight,
                        Matrix* by_z) const override {
    std::vector<Matrix> values;
    each(theta, inputs(x),
         [&](std::size_t i, const Vector& own, auto) { values.push_back(parts_[i]->between(own, x, z)); });
    Vector all(theta.size());
    if (by_z != nullptr) by_z->setZero(z.rows(), z.cols());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, Eigen::Index first) {
      Matrix part;
      all.segment(first, own.size()) =
          parts_[i]->cross_gradient(own, x, z, values[i], others(weight, values, i), by_z == nullptr ? nullptr : &part);
      if (by_z != nullptr) *by_z += part;
    });
    return all;
  }
  Vector own_gradient(const Vector& theta, const Matrix& x, const Vector& weight) const override {
    std::vector<Vector> values;
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, auto) { values.push_back(parts_[i]->at(own, x)); });
    Vector all(theta.size());
    each(theta, inputs(x), [&](std::size_t i, const Vector& own, Eigen::Index first) {
      all.segment(first, own.size()) = parts_[i]->own_gradient(own, x, others(weight, values, i));
    });
    return all;
  }
  Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const override {
    std::vector<Vector> values;
    each(theta, inputs(z), [&](std::size_t i, const Vector& own, auto) {
      values.emplace_back(parts_[i]->between(own, z, x.transpose()).col(0));
    });
    Matrix total = Matrix::Zero(z.rows(), z.cols());
    each(theta, inputs(z), [&](std::size_t i, const Vector& own, auto) {
      Vector rest = Vector::Ones(z.rows());
      for (std::size_t j = 0; j < values.size(); ++j) {
        if (j != i) rest.array() *= values[j].array();
      }
      total += rest.asDiagonal() * parts_[i]->input_gradient(own, x, z);
    });
    return total;
  }

  bool slopes(const Vector& theta, const Vector& x, const Vector& z, Matrix& block,
              std::vector<Matrix>* by_theta) const override {
    std::vector<Matrix> values(parts_.size());
    std::vector<std::vector<Matrix>> by_own(parts_.size());
    bool known = true;
    each(theta, static_cast<int>(x.size()), [&](std::size_t i, const Vector& own, auto) {
      known = known && parts_[i]->slopes(own, x, z, values[i], by_theta == nullptr ? nullptr : &by_own[i]);
    });
    if (!known) return false;
    // The product with one of the blocks replaced by another.
    const auto product = [&](std::size_t at, const Matrix& instead) {
      Matrix result = at == 0 ? instead : values[0];
      for (std::size_t i = 1; i < values.size(); ++i) result = multiplied(result, i == at ? instead : values[i]);
      return result;
    };
    block = product(0, values[0]);
    if (by_theta == nullptr) return true;
    by_theta->clear();
    for (std::size_t i = 0; i < by_own.size(); ++i) {
      for (const Matrix& each_own : by_own[i]) by_theta->push_back(product(i, each_own));
    }
    return true;
  }

  bool terms(const Vector& theta, int inputs, std::vector<GaussianTerm>& list) const override {
    std::vector<GaussianTerm> product{{1, Vector::Zero(inputs), {}}};
    bool known = true;
    each(theta, inputs, [&](std::size_t i, const Vector& own, auto) {
      std::vector<GaussianTerm> part, next;
      known = known && parts_[i]->terms(own, inputs, part);
      for (const GaussianTerm& a : product) {
        for (const GaussianTerm& b : part) {
          next.push_back({a.c * b.c, a.w + b.w, a.factors});
          next.back().factors.insert(next.back().factors.end(), b.factors.begin(), b.factors.end());
        }
      }
      product = std::move(next);
    });
    list.insert(list.end(), product.begin(), product.end());
    return known;
  }

 private:
  // The weight with the values of the parts but i.
  template <typename Values>
  static Values others(Values weight, const std::vector<Values>& values, std::size_t i) {
    for (std::size_t j = 0; j < values.size(); ++j) {
      if (j != i) weight.array() *= values[j].array();
    }
    return weight;
  }
  static int inputs(const Matrix& x) { return static_cast<int>(x.cols()); }
  // The rule of products for [k, dk/dz'; dk/dx, d2k/dx dz'].
  static Matrix multiplied(const Matrix& a, const Matrix& b) {
    const Eigen::Index d = a.rows() - 1;
    Matrix m(d + 1, d + 1);
    m(0, 0) = a(0, 0) * b(0, 0);
    m.row(0).tail(d) = a(0, 0) * b.row(0).tail(d) + b(0, 0) * a.row(0).tail(d);
    m.col(0).tail(d) = a(0, 0) * b.col(0).tail(d) + b(0, 0) * a.col(0).tail(d);
    m.bottomRightCorner(d, d) = a(0, 0) * b.bottomRightCorner(d, d) + b(0, 0) * a.bottomRightCorner(d, d) +
                                a.col(0).tail(d) * b.row(0).tail(d) + b.col(0).tail(d) * a.row(0).tail(d);
    return m;
  }
};

}  // namespace

std::shared_ptr<const Covariance> make_sum(Parts parts) { return std::make_shared<Sum>(std::move(parts)); }
std::shared_ptr<const Covariance> make_product(Parts parts) { return std::make_shared<Product>(std::move(parts)); }

}  // namespace plantloop::identify
