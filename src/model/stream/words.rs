//! The choices of a stream by their names.

use crate::model::named::named;

named!(
    /// The view of an iteration.
    View, "choice" {
        /// Its complete control points.
        ControlPoints = "control_points",
        /// Points of the curve or surface.
        Samples = "samples",
        /// Its errors alone.
        Errors = "errors",
    }
);

named!(
    /// The encoding of arrays of numbers in JSON.
    Encoding, "choice" {
        /// Lists of numbers.
        Json = "json",
        /// Little-endian numbers of 64 bits in base64.
        Base64 = "base64",
        /// Little-endian numbers of 32 bits in base64.
        Base64F32 = "base64_f32",
        /// As differences from what the reader has, in few bits.
        Delta = "delta",
    }
);

named!(
    /// The precision of coordinates in JSON.
    Digits, "choice" {
        /// All.
        Full = "full",
        /// As many as the largest distance deserves; the last iteration has all.
        Auto = "auto",
    }
);

named!(
    /// The iterations for a client that is slower than the fit.
    Pace, "choice" {
        /// All iterations.
        All = "all",
        /// The newest iteration.
        Latest = "latest",
    }
);

named!(
    /// What happens to a job when the client of its stream disconnects.
    OnDisconnect, "choice" {
        /// The job continues.
        Continue = "continue",
        /// The job is cancelled.
        Cancel = "cancel",
    }
);

named!(
    /// The contents of the `job` event.
    Describe, "choice" {
        /// All.
        Full = "full",
        /// Nothing that is as long as the data: no knots, parameters or fixed weights.
        None = "none",
    }
);

named!(
    /// One of the choices of a stream.
    Choice, "choice" {
        /// See [`StreamSpec::view`].
        View = "view",
        /// See [`StreamSpec::samples`].
        Samples = "samples",
        /// See [`StreamSpec::every`].
        Every = "every",
        /// See [`StreamSpec::milestones`].
        Milestones = "milestones",
        /// See [`StreamSpec::pace`].
        Pace = "pace",
        /// See [`StreamSpec::changed`].
        Changed = "changed",
        /// See [`StreamSpec::describe`].
        Describe = "describe",
        /// See [`StreamSpec::encoding`].
        Encoding = "encoding",
        /// See [`StreamSpec::digits`].
        Digits = "digits",
        /// See [`StreamSpec::on_disconnect`].
        OnDisconnect = "on_disconnect",
    }
);
