#include "sim/integrator/vector_operations.h"

#include <nvector/nvector_serial.h>

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

// Number of threads of all kernels called from this thread. Each make_vector() sets it, because
// SUNDIALS passes only vectors to kernels. Simulations that alternate on one thread therefore share
// the number set last. This number affects the cost but not the bits.
thread_local int vector_threads = 1;

double* data(N_Vector v) { return NV_DATA_S(v); }
int length(N_Vector v) { return static_cast<int>(NV_LENGTH_S(v)); }

// Number of threads for an operation on vectors of this length. A processor passes over a shorter
// one in less time than threads need to wait for each other.
int threads_for(int count) {
  constexpr int worth_sharing = 16384;
  return count < worth_sharing ? 1 : vector_threads;
}

// Loops have copies of their operation. Its pointers then stay in registers: through a reference,
// g++ 12 reads them anew for each number, and gathers the numbers one by one.
template <class Operation>
void for_each(int count, const Operation& operation) {
  parallel_chunks(count, threads_for(count), [&](int first, int last) {
    const Operation own = operation;
    for (int i = first; i < last; ++i) own(i);
  });
}

template <class Term>
double sum_of(int count, const Term& term) {
  return parallel_sum(count, threads_for(count), [&](int first, int last) {
    const Term own = term;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = first; i < last; ++i) sum += own(i);
    return sum;
  });
}

void linear_sum(realtype a, N_Vector x, realtype b, N_Vector y, N_Vector z) {
  const double *xs = data(x), *ys = data(y);
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = a * xs[i] + b * ys[i]; });
}

void set_constant(realtype c, N_Vector z) {
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = c; });
}

void multiply(N_Vector x, N_Vector y, N_Vector z) {
  const double *xs = data(x), *ys = data(y);
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = xs[i] * ys[i]; });
}

void divide(N_Vector x, N_Vector y, N_Vector z) {
  const double *xs = data(x), *ys = data(y);
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = xs[i] / ys[i]; });
}

void scale(realtype c, N_Vector x, N_Vector z) {
  const double* xs = data(x);
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = c * xs[i]; });
}

void absolute(N_Vector x, N_Vector z) {
  const double* xs = data(x);
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = std::fabs(xs[i]); });
}

void invert(N_Vector x, N_Vector z) {
  const double* xs = data(x);
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = 1 / xs[i]; });
}

void add_constant(N_Vector x, realtype b, N_Vector z) {
  const double* xs = data(x);
  double* zs = data(z);
  for_each(length(z), [=](int i) { zs[i] = xs[i] + b; });
}

realtype dot_product(N_Vector x, N_Vector y) {
  const double *xs = data(x), *ys = data(y);
  return sum_of(length(x), [=](int i) { return xs[i] * ys[i]; });
}

realtype weighted_rms_norm(N_Vector x, N_Vector w) {
  const double *xs = data(x), *ws = data(w);
  const int count = length(x);
  return std::sqrt(sum_of(count, [=](int i) { return (xs[i] * ws[i]) * (xs[i] * ws[i]); }) / count);
}

realtype maximum_norm(N_Vector x) {
  const double* xs = data(x);
  double largest = 0;
  for (int i = 0; i < length(x); ++i) largest = std::max(largest, std::fabs(xs[i]));
  return largest;
}

realtype weighted_norm(N_Vector x, N_Vector w) {
  const double *xs = data(x), *ws = data(w);
  return std::sqrt(sum_of(length(x), [=](int i) { return (xs[i] * ws[i]) * (xs[i] * ws[i]); }));
}

int linear_combination(int count, realtype* c, N_Vector* vectors, N_Vector z) {
  double* zs = data(z);
  const int size = length(z);
  parallel_chunks(size, threads_for(size), [&](int first, int last) {
    double* const to = zs;
    const double* const x0 = data(vectors[0]);
    const double factor0 = c[0];
    for (int i = first; i < last; ++i) to[i] = factor0 * x0[i];
    for (int k = 1; k < count; ++k) {
      const double* const xs = data(vectors[k]);
      const double factor = c[k];
      for (int i = first; i < last; ++i) to[i] += factor * xs[i];
    }
  });
  return 0;
}

int scale_add_multi(int count, realtype* a, N_Vector x, N_Vector* ys, N_Vector* zs) {
  for (int k = 0; k < count; ++k) linear_sum(a[k], x, 1, ys[k], zs[k]);
  return 0;
}

}  // namespace

N_Vector make_vector(sunindextype size, int threads, SUNContext context) {
  vector_threads = threads;
  N_Vector vector = N_VNew_Serial(size, context);
  N_Vector_Ops ops = vector->ops;
  ops->nvlinearsum = linear_sum;
  ops->nvconst = set_constant;
  ops->nvprod = multiply;
  ops->nvdiv = divide;
  ops->nvscale = scale;
  ops->nvabs = absolute;
  ops->nvinv = invert;
  ops->nvaddconst = add_constant;
  ops->nvdotprod = dot_product;
  ops->nvwrmsnorm = weighted_rms_norm;
  ops->nvmaxnorm = maximum_norm;
  ops->nvwl2norm = weighted_norm;
  ops->nvlinearcombination = linear_combination;
  ops->nvscaleaddmulti = scale_add_multi;
  set_constant(0, vector);
  return vector;
}

}  // namespace weft::sim
