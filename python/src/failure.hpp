// From error records to exceptions of Python.
#ifndef NSDAE_PYTHON_FAILURE_HPP
#define NSDAE_PYTHON_FAILURE_HPP

#include <nanobind/nanobind.h>
#include <nsdae/nsdae.h>

namespace nsdae_python
{

namespace nb = nanobind;

// The CallbackError that is to name this exception as its cause.
nb::object make_callback_error(nb::object cause);

// Raises what Python raised inside of a callback, else what the record says. With the GIL.
[[noreturn]] void raise(const nsdae_error &error);

// Nothing where status >= 0.
void check(int status, const nsdae_error *error);

void bind_failure(nb::module_ &m);

} // namespace nsdae_python

#endif
