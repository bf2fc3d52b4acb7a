//! Images as numpy arrays.

use crate::errors::{exception, input_error};
use crate::shown::type_of;
use nextview::sensor::{ColorImage, Depth, DepthImage, Intrinsics};
use nextview_scan::Fault;
use numpy::ndarray::Dimension;
use numpy::{
    Element, PyArray, PyArray2, PyArrayMethods, PyReadonlyArray, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

const DEPTH: &str = "expected an array of height x width, float32 in metres, or uint16 with `depth_scale_m`";

/// Converts a depth image of this camera: float32 in metres, or uint16 in units of `scale` metres. Masked
/// pixels are missing. Arrays of any layout are read row by row; the depths are copied once, because a frame
/// is kept.
pub fn depth_image(
    camera: &Intrinsics,
    depth: &Bound<'_, PyAny>,
    scale: Option<f64>,
    mask: Option<&Bound<'_, PyAny>>,
) -> PyResult<DepthImage> {
    let py = depth.py();
    let array = untyped("depth", depth, DEPTH)?;
    let &[height, width] = array.shape() else {
        return Err(input_error(py, format!("`depth` has the shape {:?}, {DEPTH}", array.shape())));
    };
    check_size(py, "depth", [height, width], camera)?;
    if depth.is_instance(&py.import("numpy.ma")?.getattr("MaskedArray")?)? {
        let problem = "`depth` is a masked array, expected a plain one: pass np.ma.getdata(depth), and \
                       `mask`=np.ma.getmaskarray(depth)";
        return Err(input_error(py, problem));
    }
    let mut metres = metres(depth, array, scale)?;
    if let Some(mask) = mask {
        let mask = of_kind::<bool, _>("mask", mask, [height, width], "a bool array of the depth's shape")?;
        // A numpy bool may be any byte; in Rust, it must be 0 or 1.
        let bytes = py.get_type::<PyUntypedArray>().call_method1("view", (mask, "uint8"))?;
        let mask = readonly("mask", bytes.cast::<PyArray2<u8>>()?)?;
        let masked = metres.iter_mut().zip(mask.as_array()).filter(|(_, is_masked)| **is_masked != 0);
        masked.for_each(|(depth, _)| *depth = f32::NAN);
    }
    DepthImage::from_metres(camera.width(), camera.height(), metres)
        .map_err(|error| exception(py, Fault::from(error)))
}

/// Checked before reading the content: an array of another size may be of any length without using memory.
fn check_size(py: Python<'_>, name: &str, [height, width]: [usize; 2], camera: &Intrinsics) -> PyResult<()> {
    let expected = [camera.height() as usize, camera.width() as usize];
    if [height, width] == expected {
        return Ok(());
    }
    let expected = format!("{} x {} pixels, as the camera has", expected[1], expected[0]);
    Err(exception(py, Fault::of_value(name, format!("{width} x {height}"), expected)))
}

/// Converts a colour image of this camera: height x width x 3, uint8, red first.
pub fn color_image(camera: &Intrinsics, color: &Bound<'_, PyAny>) -> PyResult<ColorImage> {
    let py = color.py();
    let expected = "a uint8 array of height x width x 3";
    let array = untyped("color", color, &format!("expected {expected}"))?;
    let &[height, width, 3] = array.shape() else {
        return Err(input_error(
            py,
            format!("`color` has the shape {:?}, expected {expected}", array.shape()),
        ));
    };
    check_size(py, "color", [height, width], camera)?;
    let color = readonly("color", of_kind::<u8, _>("color", color, [height, width, 3], expected)?)?;
    let view = color.as_array();
    let pixel = |v: usize, u: usize| [view[[v, u, 0]], view[[v, u, 1]], view[[v, u, 2]]];
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| (v, u))).map(|(v, u)| pixel(v, u));
    ColorImage::new(camera.width(), camera.height(), pixels.collect())
        .map_err(|error| exception(py, Fault::from(error)))
}

/// Returns depths as float32 in metres: NaN for missing pixels, infinity for pixels without return.
pub fn depths<'py>(py: Python<'py>, image: &DepthImage) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (width, height) = (image.width(), image.height());
    let metres: Vec<f32> = image.pixels().map(Depth::metres).collect();
    PyArray::from_vec(py, metres).reshape([height as usize, width as usize])
}

fn metres(
    depth: &Bound<'_, PyAny>,
    array: &Bound<'_, PyUntypedArray>,
    scale: Option<f64>,
) -> PyResult<Vec<f32>> {
    let py = depth.py();
    if let Ok(metres) = depth.cast::<PyArray2<f32>>() {
        if scale.is_some() {
            let problem = "`depth_scale_m` is for depths in uint16; float32 is in metres";
            return Err(input_error(py, problem));
        }
        return Ok(readonly("depth", metres)?.as_array().iter().copied().collect());
    }
    let Ok(units) = depth.cast::<PyArray2<u16>>() else {
        return Err(input_error(py, format!("`depth` has the type {}, {DEPTH}", array.dtype())));
    };
    let scale = scale.ok_or_else(|| {
        let problem =
            "`depth` has the type uint16, which needs `depth_scale_m`: metres per unit, such as 0.001";
        input_error(py, problem)
    })?;
    if !(scale > 0.0 && scale.is_finite()) {
        let expected = "a positive number of metres per unit";
        return Err(exception(py, Fault::of_value("depth_scale_m", scale, expected)));
    }
    Ok(readonly("depth", units)?.as_array().iter().map(|&unit| (f64::from(unit) * scale) as f32).collect())
}

fn untyped<'a, 'py>(
    name: &str,
    value: &'a Bound<'py, PyAny>,
    expected: &str,
) -> PyResult<&'a Bound<'py, PyUntypedArray>> {
    value
        .cast::<PyUntypedArray>()
        .map_err(|_| input_error(value.py(), format!("`{name}` is of type {}, {expected}", type_of(value))))
}

/// An array of elements of type `T` along `N` axes.
type ArrayOf<T, const N: usize> = PyArray<T, numpy::ndarray::Dim<[usize; N]>>;

/// Returns the array, if it has this type and shape.
fn of_kind<'a, 'py, T: Element, const N: usize>(
    name: &str,
    value: &'a Bound<'py, PyAny>,
    shape: [usize; N],
    expected: &str,
) -> PyResult<&'a Bound<'py, ArrayOf<T, N>>>
where
    numpy::ndarray::Dim<[usize; N]>: Dimension,
{
    let py = value.py();
    let array = untyped(name, value, &format!("expected {expected}"))?;
    if array.shape() != shape {
        let problem = format!("`{name}` has the shape {:?}, expected {shape:?}, {expected}", array.shape());
        return Err(input_error(py, problem));
    }
    value
        .cast()
        .map_err(|_| input_error(py, format!("`{name}` has the type {}, expected {expected}", array.dtype())))
}

/// Returns the array for reading in place.
pub fn readonly<'py, T: Element, D: Dimension>(
    name: &str,
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadonlyArray<'py, T, D>> {
    let py = array.py();
    // References to invalid values are not allowed; a subclass may have other flags than its array.
    let flags = py.get_type::<PyUntypedArray>().getattr("flags")?.call_method1("__get__", (array,))?;
    if !flags.getattr("aligned")?.extract::<bool>()? {
        let remedy = format!("pass np.require({name}, requirements='A')");
        return Err(input_error(py, format!("`{name}` is not aligned in memory: {remedy}")));
    }
    array.try_readonly().map_err(|error| input_error(py, format!("`{name}` cannot be read: {error}")))
}
