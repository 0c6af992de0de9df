// From error records to exceptions of Python.
#ifndef NSDAE_PYTHON_FAILURE_HPP
#define NSDAE_PYTHON_FAILURE_HPP

#include <string>

#include <nanobind/nanobind.h>
#include <nsdae/nsdae.h>

namespace nsdae_python
{

namespace nb = nanobind;

// The CallbackError with this exception as its cause, of this function or None.
nb::object make_callback_error(nb::object cause, nb::object function);

// Raises the exception of the record. With the GIL.
[[noreturn]] void raise(const nsdae_error &error);

// A text of an error or warning; U+FFFD instead of bytes that are no UTF-8: a file may hold them,
// and the library cuts long texts within a character.
nb::str readable(const char *text);

// No-op if status >= 0 and no callback raised an exception. An exception counts also if the library
// recovered from it (a smaller step, a start that failed elsewhere).
void check(int status, const nsdae_error *error);

// Refused before a call of the library: ArgumentError, or Error with this status.
[[noreturn]] void refuse(int status, const char *argument, const std::string &why);

// A text for the library; a NUL character is refused, because it would end the text.
const char *text(const std::string &value, const char *argument);

// Releases the GIL for a long call of the library. Calls are counted: at the end of the interpreter
// they are interrupted and awaited. A thread that asked for the GIL later would end inside C++, and
// with it the process.
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
  } counted; // the GIL is acquired before the count decreases
  nb::gil_scoped_release gil;
};

void bind_failure(nb::module_ &m);

} // namespace nsdae_python

#endif
