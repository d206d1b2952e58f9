// The angle between two surfaces that meet in a curve, and an elastic energy of its change.
//
// At a point of the curve, t is the tangent of the curve. The vectors a and b are tangents of the
// two surfaces, and point away from the curve. The part of a that is normal to t is a - q_a t with
// q_a = a . t / t . t. It has the length h_a and the direction e_a. A normal of the surface is
// n_a = t x e_a / |t|. q_b, h_b, e_b and n_b are defined likewise for b. With the angle theta and
// the angle at rest Theta,
//   cos theta = e_a . e_b,   sin theta = n_a . e_b,
//   d theta = n_b . (db - q_b dt) / h_b - n_a . (da - q_a dt) / h_a,
//   W = k (1 - cos(theta - Theta)).
// For small changes W is k / 2 times the squared change of the angle. Source: Herrema, Johnson,
// Proserpio, Wu, Kiendl, Hsu 2019 (Penalty coupling of non-matching isogeometric Kirchhoff-Love
// shell patches), who write this energy as a sum of squares.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// The coefficients that give t, a and b at a point from the positions x_r of the nodes:
// t = sum_r t_r x_r, and likewise for a and b.
template <int nodes>
struct AngleBasis {
  using Numbers = Eigen::Array<double, nodes, 1, Eigen::DontAlign>;
  Numbers t, a, b;
};

struct AngleLaw {
  double stiffness = 0;         // k, J
  double cosine = 1, sine = 0;  // cosine and sine of the angle at rest
};

class SurfaceAngle {
 public:
  // t, a and b are in m. If a or b is parallel to t, there is no angle: sine, cosine and moments
  // are zero.
  SurfaceAngle(const Vec3& t, const Vec3& a, const Vec3& b);
  template <int nodes>
  SurfaceAngle(const AngleBasis<nodes>& basis, const NodesOf<double, nodes>& x)
      : SurfaceAngle(x * basis.t.matrix(), x * basis.a.matrix(), x * basis.b.matrix()) {}

  double cosine() const { return cosine_; }
  double sine() const { return sine_; }
  double length() const { return length_; }                       // |t|, m
  double width() const { return 0.5 * (a_.height + b_.height); }  // mean of h_a and h_b, m

  double energy(const AngleLaw& law) const;  // J
  // Return the moment dW / d theta, and the derivative of the moment by theta. Both are in J.
  double moment(const AngleLaw& law) const {
    return law.stiffness * (sine_ * law.cosine - cosine_ * law.sine);
  }
  double moment_slope(const AngleLaw& law) const {
    return law.stiffness * (cosine_ * law.cosine + sine_ * law.sine);
  }

  // Returns the gradient of the angle by the positions of the nodes, as columns, 1/m.
  template <int nodes>
  NodesOf<double, nodes> gradient(const AngleBasis<nodes>& basis) const {
    return b_.normal * (b_.beside(basis.b, basis.t) / b_.height).matrix().transpose() -
           a_.normal * (a_.beside(basis.a, basis.t) / a_.height).matrix().transpose();
  }
  // Adds `factor` times the Hessian of the angle (1/m^2).
  template <int nodes>
  void add_hessian(double factor, const AngleBasis<nodes>& basis,
                   StencilMatrix<double, nodes>& sum) const {
    a_.add_hessian(-factor, direction_, length_, basis.t, a_.beside(basis.a, basis.t), sum);
    b_.add_hessian(factor, direction_, length_, basis.t, b_.beside(basis.b, basis.t), sum);
  }

 private:
  // The vectors of one of the two surfaces. In these comments, a is the tangent of that surface.
  // The surface contributes n . u / h to d theta (with the opposite sign for the first surface),
  // where u = da - q dt = sum_r u_r dx_r.
  struct Side {
    Side(const Vec3& direction, double length, const Vec3& tangent);
    template <class Numbers>
    Numbers beside(const Numbers& tangent, const Numbers& along) const {
      return tangent - skew * along;
    }
    // Adds `factor` times the derivative of n . u / h. It follows from
    //   du = -dq dt,  dh = e . u,  dq = (t / |t| . u + h / |t| e . dt) / |t|,
    //   dn = -(e / h) (n . u) - (t / |t|^2) (n . dt).
    // The product of e . dt and n . dt is not symmetric. Only its symmetric part is added, because
    // the antisymmetric parts of both surfaces cancel.
    template <class Numbers, int nodes>
    void add_hessian(double factor, const Vec3& direction, double length, const Numbers& t,
                     const Numbers& u, StencilMatrix<double, nodes>& sum) const {
      const Mat3 turned = across * normal.transpose() + normal * across.transpose();
      const Mat3 along = normal * direction.transpose();
      for (int r = 0; r < nodes; ++r) {
        for (int s = r; s < nodes; ++s) {
          const double both =
              u[r] * u[s] / (height * height) + 0.5 * t[r] * t[s] / (length * length);
          sum(r, s) -=
              factor * (both * turned + (t[r] * u[s] * along + u[r] * t[s] * along.transpose()) /
                                            (height * length));
        }
      }
    }

    double skew = 0;       // q
    double height = 1;     // h, m
    Vec3 across{0, 0, 0};  // e
    Vec3 normal{0, 0, 0};  // n
  };

  Vec3 direction_;  // t / |t|
  double length_;
  Side a_, b_;
  double cosine_, sine_;
};

}  // namespace weft::materials
