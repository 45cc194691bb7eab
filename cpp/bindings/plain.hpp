#pragma once
// Numbers as most callers give them, read where they lie. Every function is false for anything else, without an error:
// the checks of softlimb/arguments.py then decide what it is.
#include <pybind11/numpy.h>

#include <cmath>
#include <initializer_list>
#include <vector>

#include "softlimb/se3.hpp"

namespace softlimb::bindings::plain {

namespace py = pybind11;

class Reader {
public:
    Reader()
        : array_type_(reinterpret_cast<PyTypeObject*>(
              py::object(py::module_::import("numpy").attr("ndarray")).release().ptr())),
          number_type_(py::dtype::of<double>().release()) {}

    bool truth(py::handle given, bool& out) const {
        out = given.ptr() == Py_True;
        return out || given.ptr() == Py_False;
    }
    bool tolerance(py::handle given, double& out) const {
        if (!PyFloat_CheckExact(given.ptr())) return false;
        out = PyFloat_AS_DOUBLE(given.ptr());
        return out >= 1e-12 && out <= 0.1;
    }
    /// One of the texts, by its number.
    template <class Choice>
    bool choice(py::handle given, std::initializer_list<const char*> texts, Choice& out) const {
        if (!PyUnicode_CheckExact(given.ptr())) return false;
        int number = 0;
        for (const char* text : texts) {
            out = static_cast<Choice>(number++);
            if (PyUnicode_CompareWithASCIIString(given.ptr(), text) == 0) return true;
        }
        return false;
    }
    bool three(py::handle given, double* out) const { return row(given, 3, out); }
    bool one(py::handle given, double& out) const { return number(given.ptr(), out); }

    /// A homogeneous matrix whose rotation is one, by the rule of softlimb/arguments.py.
    bool pose(py::handle given, Pose& out) const {
        if (Py_TYPE(given.ptr()) != array_type_) return false;
        const auto array = py::reinterpret_borrow<py::array>(given);
        if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) return false;
        double m[4][4];
        for (int r = 0; r < 4; ++r)
            if (!strided(array, static_cast<const char*>(array.data()) + r * array.strides(0), array.strides(1), 4,
                         m[r]))
                return false;
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) out.rotation(r, c) = m[r][c];
            out.position(r) = m[r][3];
        }
        const Matrix3 square = out.rotation * out.rotation.transpose();
        return (square - Matrix3::Identity()).cwiseAbs().maxCoeff() <= 1e-5 && out.rotation.determinant() > 0.0 &&
               m[3][0] == 0.0 && m[3][1] == 0.0 && m[3][2] == 0.0 && m[3][3] == 1.0;
    }

    /// Flat, or one row a segment.
    bool by_segment(py::handle given, const std::vector<int>& counts, std::vector<double>& out) const {
        const int total = static_cast<int>(out.size()), segments = static_cast<int>(counts.size());
        if (Py_TYPE(given.ptr()) == array_type_) {
            const auto array = py::reinterpret_borrow<py::array>(given);
            if (array.ndim() != 2) return row(given, total, out.data());
            if (array.shape(0) != segments) return false;
            for (const int count : counts)
                if (count != array.shape(1)) return false;
            for (int j = 0, first = 0; j < segments; first += counts[j++])
                if (!strided(array, static_cast<const char*>(array.data()) + j * array.strides(0), array.strides(1),
                             counts[j], out.data() + first))
                    return false;
            return true;
        }
        if (!PyList_CheckExact(given.ptr()) && !PyTuple_CheckExact(given.ptr())) return false;
        PyObject** items = PySequence_Fast_ITEMS(given.ptr());
        if (PySequence_Fast_GET_SIZE(given.ptr()) != segments || segments == 0 ||
            !(PyList_CheckExact(items[0]) || PyTuple_CheckExact(items[0]) || Py_TYPE(items[0]) == array_type_))
            return row(given, total, out.data());
        for (int j = 0, first = 0; j < segments; first += counts[j++])
            if (!row(items[j], counts[j], out.data() + first)) return false;
        return true;
    }

private:
    /// Exactly `count` finite numbers in a row.
    bool row(py::handle given, int count, double* out) const {
        if (Py_TYPE(given.ptr()) == array_type_) {
            const auto array = py::reinterpret_borrow<py::array>(given);
            if (array.ndim() != 1 || array.shape(0) != count) return false;
            return strided(array, static_cast<const char*>(array.data()), array.strides(0), count, out);
        }
        if (!PyList_CheckExact(given.ptr()) && !PyTuple_CheckExact(given.ptr())) return false;
        if (PySequence_Fast_GET_SIZE(given.ptr()) != count) return false;
        PyObject** items = PySequence_Fast_ITEMS(given.ptr());
        for (int i = 0; i < count; ++i)
            if (!number(items[i], out[i])) return false;
        return true;
    }
    bool strided(const py::array& array, const char* from, py::ssize_t step, int count, double* out) const {
        constexpr int aligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
        if (array.dtype().ptr() != number_type_.ptr() || !(array.flags() & aligned)) return false;
        double sum = 0.0;
        for (int i = 0; i < count; ++i) {
            out[i] = *reinterpret_cast<const double*>(from + i * step);
            sum += out[i] - out[i];  // NaN once a number is not finite
        }
        return sum == 0.0;
    }
    static bool number(PyObject* given, double& out) {
        if (PyFloat_Check(given)) {
            out = PyFloat_AS_DOUBLE(given);
            return std::isfinite(out);
        }
        if (!PyLong_CheckExact(given)) return false;  // a truth value is no number
        out = PyLong_AsDouble(given);
        if (out == -1.0 && PyErr_Occurred()) {
            PyErr_Clear();
            return false;
        }
        return true;
    }

    PyTypeObject* array_type_;  // for ever: the module that holds them is never unloaded
    py::handle number_type_;
};

inline const Reader& reader() {
    PYBIND11_CONSTINIT static py::gil_safe_call_once_and_store<Reader> storage;
    return storage.call_once_and_store_result([] { return Reader(); }).get_stored();
}

}  // namespace softlimb::bindings::plain
