// From error records to exceptions of Python.
#ifndef NSDAE_PYTHON_FAILURE_HPP
#define NSDAE_PYTHON_FAILURE_HPP

#include <string>

#include <nanobind/nanobind.h>
#include <nsdae/nsdae.h>

namespace nsdae_python
{

namespace nb = nanobind;

// The CallbackError that is to name this exception as its cause.
nb::object make_callback_error(nb::object cause);

// Raises what the record says. With the GIL.
[[noreturn]] void raise(const nsdae_error &error);

// Nothing where status >= 0 and no callback raised an exception: one counts also where the library
// could do without that callback (a smaller step, a start that failed elsewhere).
void check(int status, const nsdae_error *error);

// What is refused here, before the library is called: ArgumentError, or Error with this status.
[[noreturn]] void refuse(int status, const char *argument, const std::string &why);

// As the library reads it: a text with a NUL character would end there.
const char *text(const std::string &value, const char *argument);

// The GIL is given back for a call of the library that may last. Calls are counted: at the end of
// the interpreter they are interrupted and waited for, since no thread gets the GIL any more, and
// one that ends for that in the middle of C++ ends the process.
class library_call
{
public:
  library_call() = default;
  library_call(const library_call &) = delete;
  library_call &operator=(const library_call &) = delete;
  static bool ending();

private:
  struct count {
    count();
    ~count();
  } counted; // the GIL is taken again before it is counted off
  nb::gil_scoped_release gil;
};

void bind_failure(nb::module_ &m);

} // namespace nsdae_python

#endif
