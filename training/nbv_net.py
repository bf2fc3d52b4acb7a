"""Trains NBV-Net on a data set of `nextview dataset nbv-net`, and converts weights. docs/methods/nbv-net.md has the commands.

The network is the published one (Mendoza et al. 2020) but for its last layer, which is not rectified: softmax follows. Tensors have the
published names, so that weights of the published program can be converted.
"""

from pathlib import Path

import torch
from safetensors.torch import save_file
from torch.nn.functional import cross_entropy

from grid_network import GridNetwork, GridSamples
from recipe import Recipe, run

N_VIEWS = 14
UNITS = [1500, 500, 100, 50, N_VIEWS]


class NbvNet(Recipe):
    network, title = "nbv-net", "NBV-Net, Mendoza et al. 2020"
    Samples = GridSamples
    measures, decisive = ("loss", "top1", "gain"), 1

    def model(self, args):
        return GridNetwork(UNITS, getattr(args, "dropout", 0.0))

    def loss(self, model, samples, part):
        return cross_entropy(model(samples.grids[part]), samples.labels[part])

    def outputs(self, model, samples):
        return torch.cat([model(part) for part in samples.grids.split(256)])

    def judge(self, outputs, samples):
        return cross_entropy(outputs, samples.labels).item(), *self.score(outputs.argmax(1), samples)

    def views(self, outputs, samples):
        return outputs.argmax(1)

    def inputs(self, samples):
        return samples.grids.flatten(1).numpy()


def convert(args):
    """Writes weights that the published program saved (torch.save of the state_dict) as safetensors."""
    tensors = torch.load(args.weights, map_location="cpu", weights_only=True)
    NbvNet().model(args).load_state_dict(tensors)
    save_file({name: value.float().contiguous() for name, value in tensors.items()}, args.out)
    print(f"written: {args.out}")


def main():
    parser, commands, training = NbvNet().commands(__doc__, epochs=12, batch=64, step=1e-3)
    training.add_argument("--dropout", type=float, default=0.1, help="share of units that are dropped")
    training.set_defaults(options=["epochs", "batch", "step", "dropout", "seed"])
    command = commands.add_parser("convert", help="convert weights saved by the published program (.pth) to safetensors")
    command.set_defaults(run=convert)
    command.add_argument("weights", type=Path, help="a .pth file")
    command.add_argument("out", type=Path, help="a .safetensors file")
    run(parser)


if __name__ == "__main__":
    main()
