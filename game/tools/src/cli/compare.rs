//! The command line of `compare`.

use super::parse::parse_output;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const COMPARE_HELP: &str = "\
Metrics, on linear RGB over all pixels, without any gain fitting (a: the image, r: the reference):
  rmse   sqrt(mean((a - r)^2))
  nrmse  rmse / mean(r)
  bias   mean(a) / mean(r) - 1
  p95    95th percentile of |a - r|, over mean(r)
  flip   mean of the perceptual difference FLIP, tone mapped at an exposure chosen from the reference
Where mean(r) = 0 the image must be exactly zero.

Examples:
  lightwell compare a.exr reference.exr --max nrmse=0.1,bias=0.02 --difference where.png
  lightwell compare a.exr reference.exr --figure beside.png
  lightwell compare a.exr reference.exr --halves even.exr odd.exr     (the reference is the mean of both)";

/// Arguments of `compare`.
#[derive(Args, Debug)]
#[command(after_help = COMPARE_HELP)]
pub struct CompareArgs {
    /// Image: .exr, .png or .jpg
    #[arg(value_name = "A")]
    pub image: PathBuf,
    /// Reference
    #[arg(value_name = "B")]
    pub reference: PathBuf,
    /// Metrics to print
    #[arg(long, value_enum, value_delimiter = ',', default_value = "nrmse,rmse,bias,p95,flip")]
    pub metric: Vec<Metric>,
    /// Write an image of the signed difference: red too bright, blue too dark, full colour at mean(r)
    #[arg(long, value_name = "OUT.{png,exr}", value_parser = parse_output)]
    pub difference: Option<PathBuf>,
    /// Write image, reference and difference side by side, the first two exposed and tone mapped alike
    #[arg(long, value_name = "OUT.{png,exr}", value_parser = parse_output)]
    pub figure: Option<PathBuf>,
    /// Two independent halves of the reference: nrmse and rmse are then free of its noise, which is printed too
    #[arg(long, num_args = 2, value_names = ["R1", "R2"])]
    pub halves: Vec<PathBuf>,
    /// Largest value allowed (of bias: in size); past it the exit code is 1. May be given many times
    #[arg(long, value_name = "METRIC=X", value_delimiter = ',', value_parser = parse_bound)]
    pub max: Vec<(Metric, f64)>,
}

/// An error metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Relative root mean square error
    Nrmse,
    /// Root mean square error
    Rmse,
    /// Relative error of the mean
    Bias,
    /// 95th percentile of the relative error
    P95,
    /// Perceptual difference
    Flip,
}

fn parse_bound(text: &str) -> Result<(Metric, f64), String> {
    let (name, bound) = text.split_once('=').ok_or("write it as METRIC=X, for instance nrmse=0.1")?;
    let metric = Metric::from_str(name.trim(), true)
        .map_err(|_| format!("there is no metric `{}`; there are nrmse, rmse, bias, p95 and flip", name.trim()))?;
    match bound.trim().parse::<f64>() {
        Ok(bound) if bound >= 0.0 => Ok((metric, bound)),
        _ => Err(format!("`{}` is no bound; give a number, zero or more", bound.trim())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_checked() {
        assert_eq!(parse_bound("bias=0.5"), Ok((Metric::Bias, 0.5)));
        assert!(
            parse_bound("luck=1").is_err() && parse_bound("nrmse=-1").is_err() && parse_bound("nrmse=NaN").is_err()
        );
    }
}
