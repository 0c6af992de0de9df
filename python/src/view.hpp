// Arrays of NumPy over memory that they own.
#ifndef NSDAE_PYTHON_VIEW_HPP
#define NSDAE_PYTHON_VIEW_HPP

#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

namespace nsdae_python
{

namespace nb = nanobind;

using vector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using matrix = nb::ndarray<const double, nb::ndim<2>, nb::f_contig, nb::device::cpu>;
using whole_numbers = nb::ndarray<const int, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// Over memory from new double[]: [rows], or [rows x columns] column-major where columns > 0.
inline nb::object view(double *memory, int rows, int columns, bool writeable)
{
  nb::capsule owner(memory, [](void *p) noexcept { delete[] static_cast<double *>(p); });
  std::size_t shape[2] = {static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)};
  std::int64_t strides[2] = {1, rows};
  std::size_t dimensions = columns ? 2 : 1;
  if (writeable)
    return nb::cast(nb::ndarray<nb::numpy, double>(memory, dimensions, shape, owner, strides));
  return nb::cast(nb::ndarray<nb::numpy, const double>(memory, dimensions, shape, owner, strides));
}

// The values as an array [n, widths...], C-ordered; what they were in is empty afterwards.
template <class T> nb::object array_of(std::vector<T> &values, std::vector<std::size_t> shape)
{
  auto *kept = new std::vector<T>(std::move(values));
  values.clear();
  nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<T> *>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), shape.size(), shape.data(), owner));
}

template <class T> nb::object array_of(const std::vector<T> &values)
{
  std::vector<T> copy(values);
  return array_of(copy, {copy.size()});
}

inline nb::object array_of(const double *values, std::size_t n)
{
  std::vector<double> copy(values, values + n);
  return array_of(copy, {n});
}

} // namespace nsdae_python

#endif
