"""Trains NBV-Net on a data set of `nextview dataset nbv-net`, and converts weights. docs/methods/nbv-net.md has the commands.

The network is the published one (Mendoza et al. 2020) but for its last layer, which is not rectified: softmax follows. Tensors have the
published names, so that weights of the published program can be converted.
"""

import argparse
import csv
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file, save_file
from torch import nn
from torch.nn.functional import cross_entropy, dropout, max_pool3d, relu

N_VIEWS = 14
CHANNELS = [1, 10, 12, 8]
UNITS = [512, 1500, 500, 100, 50, N_VIEWS]

# The byte of a grid that stands for probability 1.
MAX_BYTE = 254

# Objects, the last digit of whose numbers is one of these, are not trained on.
VALIDATION, TEST = 8, 9


class NbvNet(nn.Module):
    def __init__(self, drop):
        super().__init__()
        self.drop = drop
        for i, (n_in, n_out) in enumerate(zip(CHANNELS, CHANNELS[1:]), 1):
            setattr(self, f"conv{i}", nn.Conv3d(n_in, n_out, 3, padding=1))
        for i, (n_in, n_out) in enumerate(zip(UNITS, UNITS[1:]), 1):
            setattr(self, f"fc{i}", nn.Linear(n_in, n_out))
        for layer in self.children():
            # He et al. 2015. PyTorch's own choice is so small that eight layers learn next to nothing for many epochs.
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)

    def forward(self, grids):
        """Logits of grids, which are bytes."""
        x = grids.unsqueeze(1).float() / MAX_BYTE
        for i in range(1, len(CHANNELS)):
            x = max_pool3d(relu(getattr(self, f"conv{i}")(x)), 2)
        x = x.flatten(1)
        for i in range(1, len(UNITS) - 1):
            x = dropout(relu(getattr(self, f"fc{i}")(x)), self.drop, self.training)
        return getattr(self, f"fc{len(UNITS) - 1}")(x)


class Samples:
    """What a data set has of the objects, the last digit of whose numbers is one of these, as tensors."""

    def __init__(self, files, digits=range(10)):
        chosen = [np.isin(file["object"] % 10, digits) for file in files]
        field = lambda name: np.concatenate([file[name][of] for file, of in zip(files, chosen)])
        self.grids = torch.from_numpy(field("grid"))
        self.labels = torch.from_numpy(field("label").astype(np.int64))
        self.n_views = torch.from_numpy(field("n_views"))
        gains = torch.from_numpy(field("gains").astype(np.float32))
        # What each view would show, as a share of what the best of the 14 would.
        self.shares = gains / gains.amax(1, keepdim=True)

    def __len__(self):
        return len(self.labels)


def load(folder):
    """The files of a data set, in the order of the objects."""
    files = sorted(Path(folder).glob("objects-*.npy"))
    if not files:
        sys.exit(f"error: {folder}: no objects-*.npy\nhint: nextview dataset nbv-net --out {folder}")
    return [np.load(file, mmap_mode="r") for file in files]


def batches(order, size):
    return (order[i : i + size] for i in range(0, len(order), size))


def logits(model, grids):
    model.eval()
    with torch.no_grad():
        return torch.cat([model(part) for part in grids.split(256)])


def judge(model, samples):
    """Cross entropy, share of samples with the right view first, and mean share of the best gain."""
    found = logits(model, samples.grids)
    return cross_entropy(found, samples.labels).item(), *score(found.argmax(1), samples)


def score(views, samples):
    right = (views == samples.labels).float().mean().item()
    return right, samples.shares.gather(1, views[:, None]).mean().item()


def train(args):
    torch.manual_seed(args.seed)
    torch.set_num_threads(args.threads)
    torch.use_deterministic_algorithms(True)
    files = load(args.data)
    parts = [Samples(files, digits) for digits in (range(VALIDATION), [VALIDATION], [TEST])]
    learned, validation, test = parts
    print("samples: {} to learn from, {} to validate with, {} to test with".format(*map(len, parts)))
    if not all(map(len, parts)):
        sys.exit("error: too few objects to learn from and to judge by\nhint: --objects 100 is enough for a try")
    # With the channels of a cell beside each other, convolutions take half the time.
    model = NbvNet(args.dropout).to(memory_format=torch.channels_last_3d)
    with open(args.out.with_suffix(".csv"), "w", newline="") as file:
        best = fit(model, learned, validation, args, file)
    write(model, args.out, best, validation, test, args)


def fit(model, learned, validation, args, file):
    """Trains the model, writes the learning curve, and leaves the weights of the epoch that names most best views of the validation;
    gives what share that is."""
    curve = csv.writer(file, lineterminator="\n")
    curve.writerow(["epoch", "training_loss", "validation_loss", "validation_top1", "validation_gain"])
    optimizer = torch.optim.Adam(model.parameters())
    n_steps = args.epochs * -(-len(learned) // args.batch)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, args.step, n_steps)
    best, weights = -1.0, None
    start = time.monotonic()
    for epoch in range(1, args.epochs + 1):
        training = learn(model, learned, optimizer, schedule, args.batch)
        loss, top1, gain = judge(model, validation)
        curve.writerow([epoch, *(f"{value:.4f}" for value in (training, loss, top1, gain))])
        file.flush()
        text = f"loss {training:.3f}; validation: loss {loss:.3f}, top-1 {top1:.3f}, gain {gain:.3f}"
        print(f"epoch {epoch}: {text} ({time.monotonic() - start:.0f} s)", flush=True)
        if top1 > best:
            best, weights = top1, {name: value.clone() for name, value in model.state_dict().items()}
    model.load_state_dict(weights)
    return best


def learn(model, samples, optimizer, schedule, size):
    """One epoch; gives the mean loss."""
    model.train()
    total = 0.0
    for part in batches(torch.randperm(len(samples)), size):
        optimizer.zero_grad()
        loss = cross_entropy(model(samples.grids[part]), samples.labels[part])
        loss.backward()
        optimizer.step()
        schedule.step()
        total += loss.item() * len(part)
    return total / len(samples)


def write(model, path, best, validation, test, args):
    """Writes the weights, halved in precision if they are as good then, and tells how good they are on the objects of the test."""
    whole = {name: value.clone() for name, value in model.state_dict().items()}
    model.load_state_dict({name: value.half().float() for name, value in whole.items()})
    is_half = judge(model, validation)[1] >= best - 0.002
    if not is_half:
        model.load_state_dict(whole)
    found = logits(model, test.grids).argmax(1)
    report(found, test)
    tensors = {name: value.half() if is_half else value for name, value in model.state_dict().items()}
    tensors = {name: value.contiguous() for name, value in tensors.items()}
    right, gain = score(found, test)
    data = tomllib.loads((args.data / "dataset.toml").read_text())
    options = f"--epochs {args.epochs} --batch {args.batch} --step {args.step} --dropout {args.dropout} --seed {args.seed}"
    card = (
        f"NBV-Net, Mendoza et al. 2020. Data: nextview dataset nbv-net --objects {data['objects']} --seed {data['seed']}. "
        f"Training: {options}. On the objects whose numbers end in {TEST}: top-1 {right:.4f}, "
        f"gain {gain:.4f} of that of the best of {N_VIEWS} views."
    )
    # As one entry: the library writes several in an order that differs from run to run.
    save_file(tensors, path, {"card": card})
    print(f"\nwritten: {path} ({'half' if is_half else 'single'} precision)")


def report(found, test):
    """Tells how good these views are, beside the best and beside random ones."""
    rows = [("NBV-Net", *score(found, test)), ("the labels", *score(test.labels, test))]
    rows.append(("random", 1 / N_VIEWS, test.shares.mean().item()))
    shares = test.shares.gather(1, found[:, None])[:, 0]
    for n in test.n_views.unique().tolist():
        part = test.n_views == n
        rows.append((f"NBV-Net after {n}", (found == test.labels)[part].float().mean().item(), shares[part].mean().item()))
    print("\non objects held out       top-1   gain / best of 14")
    for name, right, gain in rows:
        print(f"{name:24}  {right:.3f}   {gain:.3f}")


def reference(args):
    """Writes what the framework gives for the first grids of a data set, by which the Rust code is checked: for each a checksum, so that
    a grid that came out otherwise on another machine is known, and 14 logits in single precision."""
    model = NbvNet(0.0)
    model.load_state_dict({name: value.float() for name, value in load_file(args.weights).items()})
    grids = Samples(load(args.data)).grids[: args.n]
    cells = grids.flatten(1).numpy().astype(np.uint32)
    table = np.empty(len(grids), [("checksum", "<u4"), ("logits", "<f4", N_VIEWS)])
    table["checksum"] = (cells * np.arange(1, cells.shape[1] + 1, dtype=np.uint32)).sum(1, dtype=np.uint32)
    table["logits"] = logits(model, grids)
    args.out.write_bytes(table.tobytes())
    print(f"written: {args.out}, {len(grids)} grids")


def convert(args):
    """Writes weights that the published program saved (torch.save of the state_dict) as safetensors."""
    tensors = torch.load(args.weights, map_location="cpu", weights_only=True)
    NbvNet(0.0).load_state_dict(tensors)
    save_file({name: value.float().contiguous() for name, value in tensors.items()}, args.out)
    print(f"written: {args.out}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("train", help="learn weights from a data set")
    command.set_defaults(run=train)
    command.add_argument("data", type=Path, help="folder of the data set")
    command.add_argument("out", type=Path, help="file for the weights (.safetensors); beside it, the learning curve (.csv)")
    command.add_argument("--epochs", type=int, default=12)
    command.add_argument("--batch", type=int, default=64)
    command.add_argument("--step", type=float, default=1e-3, help="length of the longest steps (Adam, one cycle)")
    command.add_argument("--dropout", type=float, default=0.1, help="share of the units that are left out")
    command.add_argument("--seed", type=int, default=0)
    command.add_argument("--threads", type=int, default=1, help="another number may round in another order; more than there are idle cores cost time")
    command = commands.add_parser("reference", help="write what the framework gives for the first grids of a data set")
    command.set_defaults(run=reference)
    command.add_argument("data", type=Path)
    command.add_argument("weights", type=Path, help="a .safetensors file")
    command.add_argument("out", type=Path)
    command.add_argument("--n", type=int, default=100)
    command = commands.add_parser("convert", help="make safetensors of weights that the published program saved (.pth)")
    command.set_defaults(run=convert)
    command.add_argument("weights", type=Path, help="a .pth file")
    command.add_argument("out", type=Path, help="a .safetensors file")
    args = parser.parse_args()
    args.run(args)


if __name__ == "__main__":
    main()
