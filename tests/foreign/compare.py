"""Compares images with a reference after one gain is fitted: python compare.py REFERENCE.exr[+REFERENCE.exr…] IMAGE.exr…

Prints the gain, the bias of the mean and the nrmse (root of the mean squared error over the mean of the reference) of all
pixels, and the nrmse without the worst hundredth of them. References that are joined by + are added. Images may be larger than
the reference by a whole factor; their pixels are averaged then. Needs numpy and OpenEXR (PyPI).
"""

import sys

import numpy as np
import OpenEXR


def read(path):
    channels = OpenEXR.File(path).channels()
    for name in ("RGB", "RGBA"):
        if name in channels:
            return channels[name].pixels[..., :3].astype(float)
    layer = next(name[:-1] for name in channels if name.endswith("R"))
    return np.stack([channels[layer + color].pixels for color in "RGB"], -1).astype(float)


def shrunk(image, height):
    factor = image.shape[0] // height
    rows, columns = image.shape[0] // factor, image.shape[1] // factor
    return image.reshape(rows, factor, columns, factor, 3).mean((1, 3))


def main():
    reference = sum(read(path) for path in sys.argv[1].split("+"))
    mean = reference.mean()
    for path in sys.argv[2:]:
        image = shrunk(read(path), reference.shape[0])
        gain = (image * reference).sum() / (image * image).sum()
        squares = ((gain * image - reference) ** 2).mean(-1)
        kept = squares[squares <= np.quantile(squares, 0.99)]
        bias = image.mean() / mean - 1
        errors = [np.sqrt(part.mean()) / mean for part in (squares, kept)]
        print(f"{path}: gain {gain:.4f}, bias {100 * bias:+.2f} %, nrmse {errors[0]:.4f}, best 99 % {errors[1]:.4f}")


main()
