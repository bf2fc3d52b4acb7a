"""What the trainings of all networks have in common: reading a data set, batches, the loop over epochs, files of weights."""

import argparse
import csv
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file, save_file

# Objects, the last digit of whose numbers is one of these, are not trained on.
VALIDATION, TEST = 8, 9


class Samples:
    """What a data set has of the objects, the last digit of whose numbers is one of these, as tensors."""

    def __init__(self, files, digits=range(10)):
        chosen = [np.isin(file["object"] % 10, digits) for file in files]
        self.field = lambda name: np.concatenate([file[name][of] for file, of in zip(files, chosen)])
        self.labels = torch.from_numpy(self.field("label").astype(np.int64))
        self.n_views = torch.from_numpy(self.field("n_views"))
        self.gains = torch.from_numpy(self.field("gains").astype(np.float32))
        # What each view would show, as a share of what the best of them would.
        self.shares = self.gains / self.gains.amax(1, keepdim=True)

    def __len__(self):
        return len(self.labels)


def load(folder, network):
    """The files of a data set, in the order of the objects."""
    files = sorted(Path(folder).glob("objects-*.npy"))
    if not files:
        sys.exit(f"error: {folder}: no objects-*.npy\nhint: nextview dataset {network} --out {folder}")
    return [np.load(file, mmap_mode="r") for file in files]


def batches(order, size):
    return (order[i : i + size] for i in range(0, len(order), size))


class Recipe:
    """How to train one network. A subclass names it and says how its samples are read, fed and judged."""

    # As in `nextview dataset`, and as in the card of the weights.
    network = title = None
    Samples = Samples
    # Names of what `judge` gives, and the place of the one by which the epoch is chosen, the larger, the better.
    measures = ()
    decisive = 0

    def model(self, args):
        """The network, to be trained."""
        raise NotImplementedError

    def loss(self, model, samples, part):
        """The mean loss of these samples in training."""
        raise NotImplementedError

    def outputs(self, model, samples):
        """What the network gives for all samples."""
        raise NotImplementedError

    def judge(self, outputs, samples):
        """The measures of outputs."""
        raise NotImplementedError

    def views(self, outputs, samples):
        """The views that the outputs choose."""
        raise NotImplementedError

    def inputs(self, samples):
        """The bytes of the input of each sample, by which `reference` knows it."""
        raise NotImplementedError

    def evaluate(self, model, samples):
        model.eval()
        with torch.no_grad():
            return self.outputs(model, samples)

    def score(self, views, samples):
        """Share of samples with the right view first, and mean share of the best gain."""
        right = (views == samples.labels).float().mean().item()
        return right, samples.shares.gather(1, views[:, None]).mean().item()

    def train(self, args):
        torch.manual_seed(args.seed)
        torch.set_num_threads(args.threads)
        torch.use_deterministic_algorithms(True)
        files = load(args.data, self.network)
        parts = [self.Samples(files, digits) for digits in (range(VALIDATION), [VALIDATION], [TEST])]
        learned, validation, test = parts
        print("samples: {} to learn from, {} to validate with, {} to test with".format(*map(len, parts)))
        if not all(map(len, parts)):
            sys.exit("error: too few objects for training and evaluation\nhint: --objects 100 is enough for a try")
        model = self.model(args)
        with open(args.out.with_suffix(".csv"), "w", newline="") as file:
            best = self.fit(model, learned, validation, args, file)
        self.write(model, best, validation, test, args)

    def fit(self, model, learned, validation, args, file):
        """Trains the model, writes the learning curve, and leaves the weights of the epoch that is best by the decisive measure on the
        validation; gives that measure."""
        curve = csv.writer(file, lineterminator="\n")
        curve.writerow(["epoch", "training_loss", *(f"validation_{name}" for name in self.measures)])
        optimizer = torch.optim.Adam(model.parameters())
        n_steps = args.epochs * -(-len(learned) // args.batch)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, args.step, n_steps)
        best, weights = -float("inf"), None
        start = time.monotonic()
        for epoch in range(1, args.epochs + 1):
            training = self.learn(model, learned, optimizer, schedule, args.batch)
            found = self.judge(self.evaluate(model, validation), validation)
            curve.writerow([epoch, *(f"{value:.4f}" for value in (training, *found))])
            file.flush()
            text = ", ".join(f"{name} {value:.4f}" for name, value in zip(self.measures, found))
            print(f"epoch {epoch}: loss {training:.4f}; validation: {text} ({time.monotonic() - start:.0f} s)", flush=True)
            if found[self.decisive] > best:
                best, weights = found[self.decisive], {name: value.clone() for name, value in model.state_dict().items()}
        model.load_state_dict(weights)
        return best

    def learn(self, model, samples, optimizer, schedule, size):
        """One epoch; gives the mean loss."""
        model.train()
        total = 0.0
        for part in batches(torch.randperm(len(samples)), size):
            optimizer.zero_grad()
            loss = self.loss(model, samples, part)
            loss.backward()
            optimizer.step()
            schedule.step()
            total += loss.item() * len(part)
        return total / len(samples)

    def write(self, model, best, validation, test, args):
        """Writes the weights, halved in precision if they are as good then, and tells how good they are on the objects of the test."""
        whole = {name: value.clone() for name, value in model.state_dict().items()}
        model.load_state_dict({name: value.half().float() for name, value in whole.items()})
        is_half = self.judge(self.evaluate(model, validation), validation)[self.decisive] >= best - 0.002
        if not is_half:
            model.load_state_dict(whole)
        views = self.views(self.evaluate(model, test), test)
        self.report(views, test)
        tensors = {name: value.half() if is_half else value for name, value in model.state_dict().items()}
        tensors = {name: value.contiguous() for name, value in tensors.items()}
        right, gain = self.score(views, test)
        data = tomllib.loads((args.data / "dataset.toml").read_text())
        options = " ".join(f"--{name} {getattr(args, name)}" for name in args.options)
        card = (
            f"{self.title}. Data: nextview dataset {self.network} --objects {data['objects']} --seed {data['seed']}. "
            f"Training: {options}. On the objects whose numbers end in {TEST}: top-1 {right:.4f}, "
            f"gain {gain:.4f} of that of the best of {test.gains.shape[1]} views."
        )
        # As one entry: the library writes several in an order that differs from run to run.
        save_file(tensors, args.out, {"card": card})
        print(f"\nwritten: {args.out} ({'half' if is_half else 'single'} precision)")

    def report(self, views, test):
        """Prints how good these views are, compared with the best and with random ones."""
        rows = [("the network", *self.score(views, test)), ("the labels", *self.score(test.labels, test))]
        n = test.gains.shape[1]
        rows.append(("random", 1 / n, test.shares.mean().item()))
        shares = test.shares.gather(1, views[:, None])[:, 0]
        for n_views in test.n_views.unique().tolist():
            part = test.n_views == n_views
            right = (views == test.labels)[part].float().mean().item()
            rows.append((f"the network after {n_views}", right, shares[part].mean().item()))
        print(f"\non objects held out       top-1   gain / best of {n}")
        for name, right, gain in rows:
            print(f"{name:24}  {right:.3f}   {gain:.3f}")

    def reference(self, args):
        """Writes what the framework gives for the first samples of a data set, by which the Rust code is checked: for each a checksum, so
        that an input that came out otherwise on another machine is known, and the outputs in single precision."""
        model = self.model(args)
        model.load_state_dict({name: value.float() for name, value in load_file(args.weights).items()})
        samples = self.Samples([file[: args.n] for file in load(args.data, self.network)[:1]])
        numbers = self.inputs(samples).astype(np.uint32)
        outputs = self.evaluate(model, samples).numpy()
        table = np.empty(len(samples), [("checksum", "<u4"), ("outputs", "<f4", outputs.shape[1])])
        table["checksum"] = (numbers * np.arange(1, numbers.shape[1] + 1, dtype=np.uint32)).sum(1, dtype=np.uint32)
        table["outputs"] = outputs
        args.out.write_bytes(table.tobytes())
        print(f"written: {args.out}, {len(samples)} samples")

    def commands(self, description, epochs, batch, step):
        """A parser of the commands that all networks have, with these defaults, and its commands."""
        parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
        commands = parser.add_subparsers(required=True)
        command = commands.add_parser("train", help="learn weights from a data set")
        command.set_defaults(run=self.train, options=["epochs", "batch", "step", "seed"])
        command.add_argument("data", type=Path, help="folder of the data set")
        command.add_argument("out", type=Path, help="file for the weights (.safetensors); the learning curve (.csv) is written next to it")
        command.add_argument("--epochs", type=int, default=epochs)
        command.add_argument("--batch", type=int, default=batch)
        command.add_argument("--step", type=float, default=step, help="maximum learning rate (Adam, one cycle)")
        command.add_argument("--seed", type=int, default=0)
        command.add_argument("--threads", type=int, default=1, help="another number may round in another order; more threads than idle cores cost time")
        training = command
        command = commands.add_parser("reference", help="write the framework's outputs for the first samples of a data set")
        command.set_defaults(run=self.reference)
        command.add_argument("data", type=Path)
        command.add_argument("weights", type=Path, help="a .safetensors file")
        command.add_argument("out", type=Path)
        command.add_argument("--n", type=int, default=100)
        return parser, commands, training


def run(parser):
    args = parser.parse_args()
    args.run(args)
